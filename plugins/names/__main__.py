"""`python -m plugins.names learn`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.names", {"learn": "what is known of the looks and sizes of our categories, from random rooms"})
