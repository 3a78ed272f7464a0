"""Digital cousins of a picture: the workflow as functions, without Snakemake; `python -m roomkin` is its command.

A name is imported when it is asked for: of these `load_policy` alone brings torch, and `write_film` ManiSkill.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from roomkin.plugins.api.loaded import load_policy
    from roomkin.plugins.api.making import make_library, make_room, make_scenes, models_of
    from roomkin.plugins.films.writing import write_film

__all__ = ["load_policy", "make_library", "make_room", "make_scenes", "models_of", "write_film"]

HOMES = {"load_policy": "roomkin.plugins.api.loaded", "write_film": "roomkin.plugins.films.writing"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(HOMES.get(name, "roomkin.plugins.api.making")), name)


def __dir__() -> list[str]:
    return __all__
