"""The package as the core knows it."""

from roomkin.stages.config.packages import Package

PACKAGE = Package(
    draws={"demonstrations": "roomkin.plugins.films.writing", "evaluation": "roomkin.plugins.films.rollouts"},
)
