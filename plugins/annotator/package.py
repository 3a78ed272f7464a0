"""What the core must know of this package: nothing, no rule calls it."""

from stages.config.packages import Package

PACKAGE = Package()
