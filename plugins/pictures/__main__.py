"""`roomkin pictures COMMAND --help`."""

from roomkin.stages.cli import main

if __name__ == "__main__":
    main(
        "roomkin.plugins.pictures",
        {
            "snapshots": "contact sheets of the snapshots",
            "objects": "the picture with what was found in it",
            "cousins": "each object beside its cousins",
            "scenes": "the scenes as pictures and as GLB",
        },
    )
