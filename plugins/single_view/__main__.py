"""`python -m plugins.single_view COMMAND --help`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.single_view", {"draw": "a photograph without depth as a drawing and an input folder"})
