"""`roomkin scripted skill --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main("roomkin.plugins.scripted", {"skill": "do a task by the scripted skill on the test assets of its policies"})
