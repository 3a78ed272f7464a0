"""Command line of the stage."""

from stages.cli import main

main(
    "stages.assets",
    {
        "join": "one library of both",
        "part": "index the models of some categories",
        "snapshots": "render the yaw views of one shard of the library",
    },
)
