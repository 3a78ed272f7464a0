"""`python -m stages.extraction extract --help`."""

from stages.cli import main

main("extraction", {"extract": "objects.json and its arrays from one input folder"})
