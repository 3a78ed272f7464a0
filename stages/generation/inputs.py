"""What generation reads: objects and their clouds, cousins, the library's asset folders."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts import Cousins, InputError, Library, Objects, read_json
from stages.contracts.cousins import Cousin, ObjectCousins
from stages.contracts.objects import SceneObject


@dataclass(frozen=True)
class Inputs:
    """Everything that the scenes of all ranks share. `clouds`, `cousins`: by object id; `folders`: by asset id."""

    objects: Objects
    cousins: dict[str, ObjectCousins]
    clouds: dict[str, NDArray[np.float32]]
    folders: dict[str, Path]

    def cousin(self, item: SceneObject, rank: int) -> Cousin | str:
        """The object's cousin of a rank, the last one if it has fewer; or why it has none."""
        found = self.cousins.get(item.id)
        if item.status == "failed" or item.box is None:
            return f"extraction: {item.reason or 'no box'}"
        if found is None or found.status == "failed" or not found.cousins:
            return f"matching: {found.reason if found and found.reason else 'no cousins'}"
        if item.id not in self.clouds:
            return "extraction: no cloud"
        best_first = sorted(found.cousins, key=lambda cousin: cousin.rank)
        return best_first[min(rank, len(best_first)) - 1]


def read_clouds(path: Path) -> dict[str, NDArray[np.float32]]:
    """The clouds (N, 3) of `clouds.npz` by object id."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except (OSError, ValueError) as error:
        fix = "extraction writes it beside objects.json"
        raise InputError(path, f"cannot be read ({error.__class__.__name__}).", fix) from None


def read_inputs(cousins: Path, objects: Path, library: Path) -> Inputs:
    """Read and check all of it.

    Raises:
        InputError: a file is missing or broken, or cousins and objects are of different scenes.
    """
    matched, seen = read_json(Cousins, cousins), read_json(Objects, objects)
    if matched.scene != seen.scene:
        raise InputError(cousins, f"is of scene '{matched.scene}', {objects} of '{seen.scene}'.", "match them again")
    index = read_json(Library, library, "make it first: python -m stages.assets library")
    return Inputs(
        objects=seen,
        cousins={entry.id: entry for entry in matched.objects},
        clouds=read_clouds(objects.parent / "clouds.npz"),
        folders={entry.id: library.parent / entry.folder for entry in index.assets},
    )
