"""`roomkin claims trainings --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main("roomkin.plugins.claims", {"trainings": "how every training ended, and which failed"})
