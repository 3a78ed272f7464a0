"""The package as the core knows it."""

from stages.config.packages import Package

PACKAGE = Package(
    draws={"demonstrations": "plugins.films.demonstrations", "evaluation": "plugins.films.rollouts"},
)
