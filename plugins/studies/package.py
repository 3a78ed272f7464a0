"""What the core must know of this package: nothing, its rules call no verb of it."""

from stages.config.packages import Package

PACKAGE = Package()
