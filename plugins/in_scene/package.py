"""What the core must know of this package."""

from stages.config.demonstrations import DemonstrationsConfig
from stages.config.packages import Package

PACKAGE = Package(commands={"demonstrate": DemonstrationsConfig}, section="demonstrations")
