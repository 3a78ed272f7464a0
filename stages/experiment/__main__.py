"""`roomkin experiment COMMAND --help`."""

from roomkin.stages.cli import main

main(
    "roomkin.stages.experiment", {"select": "name twin, cousins, dissimilar asset, training and test assets of a task"}
)
