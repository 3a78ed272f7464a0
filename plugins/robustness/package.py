"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(verbs={"leave_out": None, "table": None})
