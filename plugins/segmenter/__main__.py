"""`python -m plugins.segmenter train`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.segmenter", {"train": "random rooms, and the network that learns to cut them into things"})
