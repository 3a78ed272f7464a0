"""What the core must know of this package."""

from stages.config.packages import Package
from stages.config.tables import MethodTables

PACKAGE = Package(verbs={"conditions": MethodTables}, section="tables")
