"""The package as the core knows it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package(guard="roomkin.plugins.ops.guard")
