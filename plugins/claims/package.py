"""The package as the core knows it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package(commands={"trainings": None}, draws={"tables": "roomkin.plugins.claims.more"})
