"""The package as the core knows it."""

from roomkin.stages.config.demonstrations import DemonstrationsConfig
from roomkin.stages.config.packages import Package

PACKAGE = Package(commands={"demonstrate": DemonstrationsConfig}, section="demonstrations")
