"""The package as the core knows it."""

from stages.config.assets import LibraryOptions
from stages.config.packages import Package

PACKAGE = Package(commands={"library": LibraryOptions}, section="assets", facts="plugins.furniture facts")
