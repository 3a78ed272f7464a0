"""The package as the core knows it."""

from roomkin.stages.config.assets import LibraryOptions
from roomkin.stages.config.packages import Package

PACKAGE = Package(commands={"library": LibraryOptions}, section="assets", facts="roomkin.plugins.furniture facts")
