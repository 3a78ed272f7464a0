"""Command line of the stage."""

from stages.cli import main

main(
    "assets",
    {
        "import": "look at a folder of models: what each is taken for, to correct, and a page of pictures",
        "library": "make the procedural models and import the user's folders",
        "snapshots": "render the yaw views of one shard of the library",
        "draw": "contact sheets of the snapshots",
    },
)
