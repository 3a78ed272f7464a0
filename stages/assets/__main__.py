"""Command line of the stage."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.assets",
    {
        "join": "one library of both",
        "part": "index the models of some categories",
        "snapshots": "render the yaw views of one shard of the library",
    },
)
