"""The package as the core knows it."""

from stages.config.packages import Package

PACKAGE = Package(draws={"generation": "plugins.look.estimate"})
