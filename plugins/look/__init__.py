"""The look of a picture: where floor and walls are seen, their colors, and where the light comes from."""
