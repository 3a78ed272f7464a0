"""`python -m stages.experiment VERB --help`."""

from stages.cli import main

main(
    "experiment",
    {
        "select": "name twin, cousins and dissimilar asset of a task",
        "draw": "one picture of them with their roles and attributes",
    },
)
