"""The direction up that the files of a folder share, where their kind (OBJ, STL, PLY) agrees on none."""

from collections.abc import Mapping, Sequence

import numpy as np

from stages.articulated.mesh_reader import load_meshes
from stages.assets.discover import Found
from stages.assets.importers import Axis, Importer
from stages.assets.proportions import leaning
from stages.contracts.errors import InputError

LOOKED_AT = 30  # files of a kind
LARGEST_FILE = 5_000_000  # bytes, of those that are looked at
LEAST, MAJORITY = 3, 3.0  # models that tell, and how many times more of them must say one direction than the other


def shared_up(found: Sequence[Found], kinds: Mapping[str, Importer]) -> dict[str, Axis]:
    """By suffix, the direction up of nearly all the models that tell one; kinds whose models do not are not in it."""
    shared: dict[str, Axis] = {}
    for kind in [kind for kind, importer in kinds.items() if not importer.has_up]:
        files = [one.path for one in found if one.path.suffix.lower() == kind]
        files = [path for path in files if path.stat().st_size < LARGEST_FILE]
        told = {"+y": 0, "+z": 0}
        for index in sorted({*np.linspace(0, len(files) - 1, LOOKED_AT).round().astype(int)} if files else ()):
            try:
                points = np.concatenate([mesh.vertices for mesh in load_meshes(files[index])])
            except InputError:  # said when it is imported
                continue
            if up := leaning(points):
                told[up] += 1
        more, fewer = sorted(told.values(), reverse=True)
        if more >= max(LEAST, MAJORITY * fewer):
            shared[kind] = "+y" if told["+y"] == more else "+z"
    return shared
