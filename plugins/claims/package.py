"""The package as the core knows it."""

from stages.config.packages import Package

PACKAGE = Package(commands={"trainings": None}, draws={"tables": "plugins.claims.more"})
