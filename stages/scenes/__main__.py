"""`python -m stages.scenes render --help`."""

from stages.cli import main

main("scenes", {"render": "furnish and photograph one room"})
