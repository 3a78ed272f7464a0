"""`roomkin generation COMMAND --help`."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.generation",
    {
        "generate": "place the cousins of every rank: scene_<rank>.json",
    },
)
