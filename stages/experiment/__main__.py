"""`python -m stages.experiment COMMAND --help`."""

from stages.cli import main

main(
    "stages.experiment",
    {
        "select": "name twin, cousins, dissimilar asset, training and test assets of a task",
    },
)
