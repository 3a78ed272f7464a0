"""`python -m plugins.in_scene demonstrate --help`."""

from stages.cli import main

if __name__ == "__main__":
    main("plugins.in_scene", {"demonstrate": "a demonstration in every generated scene, with a film of it"})
