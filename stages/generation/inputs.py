"""The inputs of generation: every object with its cloud and its cousins, and the library's models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import Cousins, InputError, Objects, read_json
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.contracts.cousins import Cousin, ObjectCousins
from roomkin.stages.contracts.extracted import read_clouds, read_metres, read_object_masks
from roomkin.stages.contracts.hand import Correction, digest_of_picture, read_corrections
from roomkin.stages.contracts.images import read_masks, read_rgb
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.matched import match_corrections
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.generation.placed import RGB, measure_colors
from roomkin.stages.geometry.boxes import THINNEST
from roomkin.stages.geometry.frames import back_project, transform_points, view_angle
from roomkin.stages.geometry.masks import Outline, central_crop, measure_outline
from roomkin.stages.geometry.robust import REACH


@dataclass(frozen=True)
class MatchedObject:
    """One object with all that is known of it.

    cousins: best first. distances: of its label to categories. cloud: (N, 3), floor frame. outline: of its mask; None:
    it has none. correction: what a person says of it. failed: why no cousin can stand for it; empty: one can. color:
    that its cousins are painted in; None: they keep theirs.
    """

    object: SceneObject
    cousins: list[Cousin]
    distances: Mapping[str, float]
    cloud: NDArray[np.float32]
    outline: Outline | None
    correction: Correction
    failed: str = ""
    color: RGB | None = None


@dataclass(frozen=True)
class Inputs:
    """The inputs that the scenes of all ranks share.

    objects: as extraction wrote them. matched: an object that takes the model of another one comes after that one.
    folders: of the library's models, by asset id. categories: by name, as the library knows them.
    """

    objects: Objects
    matched: list[MatchedObject]
    folders: Mapping[str, Path]
    categories: Mapping[str, CategoryFacts]

    @property
    def supports(self) -> dict[str, str]:
        """By object, what carries it as a person says."""
        return {item.id: item.support for item in self.objects.objects if item.support}

    @property
    def nudges(self) -> dict[str, Sequence[float] | None]:
        """By object, metres (x, y) by which a person moves it."""
        return {one.object.id: one.correction.nudge for one in self.matched}


def read_inputs(
    cousins: Path,
    objects: Path,
    library: Path,
    corrections: tuple[Path, ...] = (),
    input: Path | None = None,
    image: Path | None = None,
) -> Inputs:
    """Read and check all of it.

    Args:
        corrections: corrections.json, if there is one, of the picture of the folder `input`.
        image: the picture, if cousins are painted in its colors.

    Raises:
        InputError: a file is missing or broken, or cousins and objects are of different scenes.
    """
    matched, extracted = read_json(Cousins, cousins), read_json(Objects, objects)
    if matched.scene != extracted.scene:
        what = f"is of scene '{matched.scene}', {objects} of '{extracted.scene}'."
        raise InputError(cousins, what, "match them again", code="E-SCENE-MIXED")
    clouds = read_clouds(objects, extracted)
    masks = read_object_masks(objects, extracted)
    outlines = measure_outlines(extracted, masks, read_metres(objects, extracted))
    colors = measure_colors(read_rgb(image), masks, extracted) if image else {}
    corrected = _match_corrections(corrections, input)
    by_id = {entry.id: entry for entry in matched.objects}
    found = []
    for item in extracted.objects:
        entry = by_id.get(item.id)
        found.append(MatchedObject(
            object=item, cousins=_turn(item, extracted, entry.cousins) if entry else [],
            distances={match.category: match.distance for match in entry.categories} if entry else {},
            cloud=clouds.get(item.id, np.empty((0, 3), np.float32)), outline=outlines.get(item.id),
            correction=corrected.get(item.mask, Correction(mask=item.mask)),
            failed=_find_failure(item, entry, item.id in clouds), color=colors.get(item.id),
        ))  # fmt: skip
    folders = AssetFolders(library)
    return Inputs(extracted, _sort_leaders_first(found), folders, folders.categories)


def _match_corrections(corrections: tuple[Path, ...], folder: Path | None) -> dict[int, Correction]:
    """The corrections by the mask values that things have in the input; what is not applied is printed."""
    said = read_corrections(corrections).read_by("generation")
    if folder is None or not corrections:
        return {item.mask: item for item in said.objects}
    matched = match_corrections(said, read_masks(folder / "masks.png"), digest_of_picture(folder))
    print("".join(f"{line}\n" for line in matched.lines), end="")
    return matched.corrections


def _find_failure(item: SceneObject, entry: ObjectCousins | None, has_cloud: bool) -> str:
    """Why no cousin can stand for an object; empty: one can."""
    if item.status == "failed" or item.box is None:
        return f"extraction: {item.reason or 'no box'}"
    if entry is None or entry.status == "failed" or not entry.cousins:
        return f"matching: {entry.reason if entry and entry.reason else 'no cousins'}"
    return "" if has_cloud else "extraction: no cloud"


def _turn(item: SceneObject, scene: Objects, cousins: list[Cousin]) -> list[Cousin]:
    """The cousins, best first; turned as the input says if it tells where the front is: no view needs to be matched."""
    best_first = sorted(cousins, key=lambda cousin: cousin.rank)
    if item.front is None or item.box is None:
        return best_first
    psi = view_angle(np.array(scene.floor_from_camera)[:3, 3], item.box.center, item.front)
    turns = [cousin.orientation.model_copy(update={"yaw": psi}) for cousin in best_first]
    return [
        cousin.model_copy(update={"orientation": turn, "orientations": []})
        for cousin, turn in zip(best_first, turns, strict=True)
    ]


def _sort_leaders_first(matched: list[MatchedObject]) -> list[MatchedObject]:
    """Objects in an order in which one that takes another's model comes after it."""
    by_mask = {one.object.mask: one for one in matched}

    def leaders(one: MatchedObject) -> int:
        like = one.correction.like
        return 0 if like not in by_mask else 1 + leaders(by_mask[like])

    return sorted(matched, key=leaders)


def measure_outlines(
    objects: Objects, masks: NDArray[np.uint16], depth: NDArray[np.float32] | None
) -> dict[str, Outline]:
    """The outlines of the objects that are seen, by id; without depth nothing hides anything."""
    inside = central_crop(masks.shape, objects.crop)

    def noise(distance: NDArray[np.floating]) -> NDArray[np.float64]:
        with np.errstate(invalid="ignore"):  # where nothing is, infinitely far, there is none to know
            return np.asarray(REACH * objects.depth_error.predict(distance))

    if depth is None:
        shown = np.zeros(masks.shape, np.float32)
    else:  # the floor before a thing is nearer, and hides nothing
        points = transform_points(np.array(objects.floor_from_camera), back_project(depth, objects.intrinsics))
        shown = np.where((depth > 0) & (points[..., 2] < THINNEST + noise(depth)), np.inf, depth)

    return {
        item.id: measure_outline(mask, shown, inside, noise)
        for item in objects.objects
        if item.box is not None and (mask := masks == item.mask).any()
    }
