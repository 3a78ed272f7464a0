"""What generation reads: objects and their clouds, cousins, the library's asset folders."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts import Cousins, InputError, Objects, read_json
from stages.contracts.corrections import Correction, corrections_of
from stages.contracts.cousins import Cousin, ObjectCousins
from stages.contracts.extracted import read_clouds, read_object_masks
from stages.contracts.library_folder import AssetFolders
from stages.contracts.objects import SceneObject
from stages.geometry.viewing import view_angle

AS_NEAR = 0.05  # of distances of labels: a lamp is a table lamp (0.14) or a floor lamp (0.15)


@dataclass(frozen=True)
class Inputs:
    """Everything that the scenes of all ranks share. `clouds`, `cousins`: by object id; `folders`: by asset id.

    bearings: by object id, the least and the largest level direction (radians, floor frame) in which it is seen.
    told: by mask value, what a person says of an object.
    """

    objects: Objects
    cousins: dict[str, ObjectCousins]
    clouds: dict[str, NDArray[np.float32]]
    folders: Mapping[str, Path]
    bearings: dict[str, tuple[float, float]]
    told: Mapping[int, Correction] = field(default_factory=dict)

    def said(self, item: SceneObject) -> Correction:
        """What a person says of an object."""
        return self.told.get(item.mask, Correction(mask=item.mask))

    def ranked(self, item: SceneObject) -> list[Cousin] | str:
        """The object's cousins, best first; or why it has none."""
        matched = self.cousins.get(item.id)
        if item.status == "failed" or item.box is None:
            return f"extraction: {item.reason or 'no box'}"
        if matched is None or matched.status == "failed" or not matched.cousins:
            return f"matching: {matched.reason if matched and matched.reason else 'no cousins'}"
        if item.id not in self.clouds:
            return "extraction: no cloud"
        best_first = sorted(matched.cousins, key=lambda cousin: cousin.rank)
        return [self._facing(item, cousin) for cousin in best_first]

    def called(self, item: SceneObject, category: str) -> set[str]:
        """The categories that an object's label means as much as one of them, which it is among."""
        near = {match.category: match.distance for match in self.cousins[item.id].categories}
        return {category, *(name for name, far in near.items() if far <= near.get(category, -np.inf) + AS_NEAR)}

    def _facing(self, item: SceneObject, cousin: Cousin) -> Cousin:
        """The cousin, turned as the input says if it tells where the front is: then no view needs to be matched."""
        if item.front is None or item.box is None:
            return cousin
        camera = np.array(self.objects.floor_from_camera)[:3, 3]
        psi = view_angle(camera, item.box.center, item.front)
        told = cousin.orientation.model_copy(update={"yaw": psi})
        return cousin.model_copy(update={"orientation": told, "orientations": []})


def read_inputs(cousins: Path, objects: Path, library: Path, corrections: tuple[Path, ...] = ()) -> Inputs:
    """Read and check all of it.

    Raises:
        InputError: a file is missing or broken, or cousins and objects are of different scenes.
    """
    matched, extracted = read_json(Cousins, cousins), read_json(Objects, objects)
    if matched.scene != extracted.scene:
        raise InputError(
            cousins, f"is of scene '{matched.scene}', {objects} of '{extracted.scene}'.", "match them again"
        )
    return Inputs(
        objects=extracted,
        cousins={entry.id: entry for entry in matched.objects},
        clouds=read_clouds(objects, extracted),
        folders=AssetFolders(library),
        bearings=bearings_of(extracted, read_object_masks(objects, extracted)),
        told=corrections_of(corrections, "generation"),
    )


def bearings_of(objects: Objects, masks: NDArray[np.uint16]) -> dict[str, tuple[float, float]]:
    """Between which level directions each object is seen, from the outer edges of its pixels."""
    pose, found = np.array(objects.floor_from_camera), {}
    turn = pose[:3, :3] @ np.linalg.inv(np.array(objects.intrinsics))
    for item in objects.objects:
        rows, columns = np.nonzero(masks == item.mask)
        if item.box is None or not len(rows):
            continue
        middle = np.arctan2(*(np.array(item.box.center)[:2] - pose[:2, 3])[::-1])
        x, y, _ = turn @ [np.concatenate([columns - 0.5, columns + 0.5]), np.tile(rows, 2), np.ones(2 * len(rows))]
        off = np.angle(np.exp(1j * (np.arctan2(y, x) - middle)))
        found[item.id] = (float(middle + off.min()), float(middle + off.max()))
    return found
