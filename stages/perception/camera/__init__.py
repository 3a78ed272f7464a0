"""The camera, the ground and the walls of a room."""
