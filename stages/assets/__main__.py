"""Command line of the stage."""

from stages.cli import main

main(
    "stages.assets",
    {
        "import": "look at a folder of models: what each is taken for, to correct, and a page of pictures",
        "library": "make the procedural models",
        "own": "import some models of a user's folder",
        "join": "one library of both",
        "snapshots": "render the yaw views of one shard of the library",
        "draw": "contact sheets of the snapshots",
    },
)
