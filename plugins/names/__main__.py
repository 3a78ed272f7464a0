"""`python -m plugins.names learn`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.names", {"learn": "shapes in random rooms, and the network that names them"})
