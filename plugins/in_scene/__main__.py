"""`roomkin in_scene demonstrate --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main("roomkin.plugins.in_scene", {"demonstrate": "a demonstration in every generated scene, with a film of it"})
