"""`python -m stages.extraction COMMAND --help`."""

from stages.cli import main

main("stages.extraction", {"extract": "objects.json and its arrays from one input folder"})
