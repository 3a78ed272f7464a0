"""`roomkin scenes render --help`."""

from roomkin.stages.cli import main

main("roomkin.plugins.scenes", {"render": "furnish and photograph one room"})
