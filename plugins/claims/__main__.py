"""`python -m plugins.claims trainings --help`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.claims", {"trainings": "how every training ended, and which failed"})
