"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(guard="plugins.ops.guard")
