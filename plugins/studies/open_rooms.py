"""Helpers for the rules of rooms that are not ours, from `benchmarks/open_rooms`, which only a clone has."""

from collections.abc import Callable
from typing import Any

from roomkin.stages.config.code import files_digest


def digest_of(*files: str) -> Callable[[Any], str]:
    """A parameter of a rule: the digest of files of the benchmark."""
    return lambda wildcards: files_digest(f"benchmarks/open_rooms/{name}" for name in files)


def picture_names(wildcards: Any) -> list[str]:
    """The names of all pictures."""
    from benchmarks.open_rooms import packs, rooms

    return [name for half in packs.HALVES for name in rooms.names(half)]
