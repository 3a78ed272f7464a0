"""`python -m stages.generation generate --help`."""

from stages.cli import main

main("generation", {"generate": "place the cousins of every rank: scene_<rank>.json, .png and .glb"})
