"""`python -m stages.encoder VERB --help`."""

from stages.cli import main

main(
    "encoder",
    {
        "render": "photograph models that are in no library, twice each: as a snapshot and as a room may show them",
        "train": "train the network on those pairs",
    },
)
