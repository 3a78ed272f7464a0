"""Command line of the stage."""

from stages.cli import main

main(
    "assets",
    {
        "library": "make the procedural models and import the user's folders",
        "snapshots": "render the yaw views of one shard of the library",
        "draw": "contact sheets of the snapshots",
    },
)
