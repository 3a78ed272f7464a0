"""The package as the core knows it."""

from stages.config.demonstrations import DemonstrationsConfig
from stages.config.packages import Package

PACKAGE = Package(commands={"demonstrate": DemonstrationsConfig}, section="demonstrations")
