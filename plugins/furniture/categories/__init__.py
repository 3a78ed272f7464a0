"""The categories of the library, one or several to a module, each with the generators of its models.

To add one, put a module here (docs/assets.md): nothing else names it.
"""

import pkgutil
from importlib import import_module
from types import ModuleType


def modules() -> list[ModuleType]:
    """All modules here."""
    return [import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__)]
