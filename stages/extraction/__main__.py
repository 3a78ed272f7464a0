"""`roomkin extraction COMMAND --help`."""

from roomkin.stages.cli import main

main("roomkin.stages.extraction", {"extract": "objects.json and its arrays from one input folder"})
