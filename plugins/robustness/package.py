"""The package as the core knows it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package(commands={"leave_out": None, "table": None})
