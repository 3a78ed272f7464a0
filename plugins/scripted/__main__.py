"""`python -m plugins.scripted skill --help`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.scripted", {"skill": "do a task by the scripted skill on the test assets of its policies"})
