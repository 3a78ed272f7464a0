"""The package as the core knows it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package(commands=dict.fromkeys(["snapshots", "objects", "cousins", "scenes"]))
