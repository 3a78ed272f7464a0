"""`python -m plugins.scenes render --help`."""

from stages.cli import main

main("plugins.scenes", {"render": "furnish and photograph one room"})
