"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(
    draws={"demonstrations": "plugins.films.demonstrations", "evaluation": "plugins.films.rollouts"},
)
