"""The package as the core knows it."""

from stages.config.packages import Package

PACKAGE = Package(guard="plugins.ops.guard")
