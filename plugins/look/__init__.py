"""The look of a picture: where floor and walls are seen, their colours, and where the light comes from."""
