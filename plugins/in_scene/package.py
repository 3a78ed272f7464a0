"""The package as the core knows it."""

from roomkin.stages.config.packages import Package
from roomkin.stages.config.training import DemonstrationsConfig

PACKAGE = Package(commands={"demonstrate": DemonstrationsConfig}, section="demonstrations")
