"""`python -m stages.training COMMAND`."""

from stages.cli import main

main(
    "stages.training",
    {
        "train": "train one policy on episode stores",
    },
)
