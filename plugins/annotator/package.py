"""What the core must know of this package: nothing, no rule calls it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package()
