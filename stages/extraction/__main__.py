"""`python -m stages.extraction VERB --help`."""

from stages.cli import main

main("stages.extraction", {"extract": "objects.json and its arrays from one input folder"})
