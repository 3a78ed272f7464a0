"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(commands=dict.fromkeys(["snapshots", "objects", "cousins", "scenes"]))
