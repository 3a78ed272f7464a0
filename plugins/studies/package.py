"""What the core must know of this package."""

from plugins.studies.pinned_assets import pinned_assets
from stages.config.packages import Package
from stages.config.tables import MethodTables

PACKAGE = Package(verbs={"conditions": MethodTables, "pinned": None}, section="tables", mistakes=pinned_assets)
