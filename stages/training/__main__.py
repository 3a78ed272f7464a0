"""`roomkin training COMMAND`."""

from roomkin.stages.cli import main

main("roomkin.stages.training", {"train": "train one policy on episode stores"})
