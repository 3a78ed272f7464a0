"""`python -m stages.generation COMMAND --help`."""

from stages.cli import main

main(
    "stages.generation",
    {
        "generate": "place the cousins of every rank: scene_<rank>.json",
    },
)
