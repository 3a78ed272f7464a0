"""What the core must know of this package."""

from stages.config.packages import Package

PACKAGE = Package(commands={"trainings": None}, draws={"tables": "plugins.claims.more"})
