"""What the core must know of this package."""

from stages.config.packages import Package
from stages.config.tables import PolicyTables, TablesConfig

PACKAGE = Package(
    verbs={"viewer": None, "report": PolicyTables, "overview": None, "picture": TablesConfig}, section="tables"
)
