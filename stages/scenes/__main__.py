"""`python -m stages.scenes render --help`."""

from stages.cli import main

main("stages.scenes", {"render": "furnish and photograph one room"})
