"""What the core must know of this package."""

from stages.config.assets import LibraryOptions
from stages.config.packages import Package

PACKAGE = Package(commands={"library": LibraryOptions}, section="assets", facts="plugins.furniture facts")
