"""A generated scene for other tools: a module per format, with `write(room, folder)`."""
