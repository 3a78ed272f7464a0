"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(verbs=dict.fromkeys(["snapshots", "objects", "cousins", "scenes"]))
