"""`roomkin demonstrations COMMAND`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main("roomkin.stages.demonstrations", {"collect": "run the skill on one asset until enough attempts succeed"})
