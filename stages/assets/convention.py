"""What the mesh files of a folder share: the direction up (OBJ, STL and PLY have none that is agreed) and the unit."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from stages.articulated.mesh_reader import load_meshes
from stages.articulated.model import Matrix
from stages.assets.discover import WHOLE, Found
from stages.assets.importers import Axis, Importer
from stages.assets.imports import in_one_line
from stages.assets.proportions import leaning, other_up, unit_told
from stages.contracts.errors import InputError

T = TypeVar("T")
LOOKED_AT = 30  # files of a kind
LARGEST_FILE = 5_000_000  # bytes, of those that are looked at
LEAST, MAJORITY = 3, 3.0  # models that tell, and how many times more of them must say one thing than all others


class Shared(NamedTuple):
    """What nearly all the models of a kind have in common that tell it: direction up, metres per unit; or None."""

    up: Axis | None = None
    unit: float | None = None


NOTHING = Shared()


def shared(found: Sequence[Found], kinds: Mapping[str, Importer]) -> dict[str, Shared]:
    """What the mesh files of each kind share, by suffix."""
    common = {}
    for kind in kinds.keys() - WHOLE:
        models = [one for one in found if one.path.suffix.lower() == kind and one.path.stat().st_size < LARGEST_FILE]
        step = max(1, -(-len(models) // LOOKED_AT))
        points = [(one.category, shape) for one in models[::step] if (shape := _points(one)) is not None]
        up = _most([up for _, shape in points if (up := leaning(shape))])
        if kinds[kind].has_up and up == kinds[kind].up:  # as agreed; one that only stands otherwise may still
            up = None
        ups = [up] if up else [kinds[kind].up, other_up(kinds[kind].up)]
        units = [unit_told(np.ptp(shape, axis=0), category, ups) for category, shape in points]
        common[kind] = Shared(up, _most([unit for unit in units if unit is not None]))
    return common


def _points(one: Found) -> Matrix | None:
    """The vertices of a model; None: it cannot be imported, which is said then."""
    if not one.path.resolve().is_relative_to(one.folder.resolve()):
        return None
    try:
        with in_one_line(one.path):
            return np.concatenate([mesh.vertices for mesh in load_meshes(one.path)])
    except InputError:
        return None


def _most(told: Sequence[T]) -> T | None:
    """What most of them say; None: they are too few, or do not agree."""
    for value, count in Counter(told).most_common(1):
        if count >= max(LEAST, MAJORITY * (len(told) - count)):
            return value
    return None
