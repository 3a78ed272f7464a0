"""`python -m stages.experiment VERB --help`."""

from stages.cli import main

main(
    "stages.experiment",
    {
        "select": "name twin, cousins, dissimilar asset, training and test assets of a task",
        "pinned": "take them from a committed file, if the library has the very same models",
    },
)
