"""Results of the last run of an input folder: boxes, doubts, cousins with pictures."""

import base64
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.annotator.cures import Cure
from roomkin.plugins.report.album import SnapshotShards, views_of
from roomkin.plugins.report.doubts import collect_doubts, measure_side
from roomkin.stages.contracts import Cousins, GeneratedScene, Library, Objects, read_json
from roomkin.stages.contracts.cousins import ObjectCousins
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.objects import SceneObject, Wall
from roomkin.stages.contracts.types import Pixel
from roomkin.stages.extraction.depth_error import NICHE
from roomkin.stages.geometry.boxes import FACES, UprightBox, corners, extents, front_corners, is_behind
from roomkin.stages.geometry.frames import invert_transform, project, transform_points
from roomkin.stages.tables.rows import variant_key

MAX_MODELS = 24  # models that can be chosen, nearest first


def describe_doubt(doubt: Doubt | str, cures: Sequence[Cure] = (), side: float = 1.0) -> dict[str, Any]:
    """A doubt, or why there is nothing to doubt, as the page shows it, and what one click does against it; `side`:
    that of the thing (`measure_side`)."""
    cause, text, chance = (doubt.cause, doubt.what, doubt.chance) if isinstance(doubt, Doubt) else ("", doubt, 1.0)
    leads = "affordance" if doubt == DoubtKind.NO_FIT.of() else cause  # to the models
    return {"text": text, "cause": cause, "leads": leads, "harm": chance * side, "cures": cures}


@dataclass(frozen=True)
class LastRun:
    """What a run made; all of it by mask value. Without a run it is empty.

    picture: of the scene of rank 1, as the camera sees it, if it was drawn; sizes: width, depth and height of the
    library's models, by id; views: `views_of` a thing in the scenes of all ranks.
    """

    objects: Objects | None
    items: dict[int, SceneObject]
    cousins: dict[int, ObjectCousins]
    placed: dict[int, PlacedObject]
    snapshots: SnapshotShards
    picture: Path | None = None
    sizes: dict[str, list[float]] = field(default_factory=dict)
    views: dict[int, dict[str, float]] = field(default_factory=dict)

    def describe(self, item: SceneObject, cure: Callable[[Doubt, int], list[Cure]]) -> dict[str, Any]:
        """What the page shows of a thing; `cure`: what helps against a doubt about one of a mask value."""
        entry, placed = self.cousins.get(item.mask), self.placed.get(item.mask)
        found: Sequence[Doubt | str] = []
        if item.status == "failed":
            found = [f"not found: {item.reason}"]
        elif entry is not None and entry.status == "failed":
            found = [f"no cousins: {entry.reason}"]
        elif entry is not None and self.objects is not None:
            found = collect_doubts(entry, item, placed, self.objects)
        doubts: list[dict[str, Any]] = []
        for one in found:
            offered = [each for doubt in doubts for each in doubt["cures"]]  # each click stands once
            cures = cure(one, item.mask) if isinstance(one, Doubt) else []
            new = [each for each in cures if each not in offered]
            doubts.append(describe_doubt(one, new, measure_side(item, placed)))
        about: dict[str, Any] = {"id": item.id, "label": item.label, "doubts": doubts}
        if placed is None or placed.status == "failed":
            return about
        depth, width, height = placed.size
        size = [round(extent, 3) for extent in (width, depth, height)]
        return about | {"size": size, "front": placed.yaw, "support": placed.support, "model": placed.asset}

    def faces(
        self, correction: Correction, before: tuple[float, float], at: tuple[Wall, tuple[Pixel, Pixel]] | None = None
    ) -> list[list[list[float]]]:
        """The sides of an object of the scene of rank 1 as pixels, its front last; none if a corner is behind the
        camera.

        Args:
            correction: the correction so far; the object is shown turned, moved and sized by it.
            before: (x, y) metres by which the last run had moved it already.
            at: the wall at which a person says that it hangs, and opposite corners of what shows it: what is far behind
            the wall is put onto it, as extraction does.
        """
        placed = self.placed.get(correction.mask)
        if placed is None or placed.status == "failed" or self.objects is None:
            return []
        box, hangs = UprightBox(placed.position, placed.size, placed.yaw), placed.support == "wall"
        if at is not None and is_behind(box, at[0].normal, at[0].offset - NICHE):
            hung = hang_on(self.objects, at[0], at[1], box.size)
            box, hangs = hung or box, hung is not None or hangs
        size, center = np.array(box.size), np.array(box.center)
        if correction.size is not None:
            width, depth, height = correction.size
            center[2] += 0 if hangs else (height - size[2]) / 2
            size = np.array([depth, width, height])
        center[:2] += np.subtract(correction.nudge or (0.0, 0.0), before)
        points = corners(UprightBox(center, size, box.yaw if correction.front is None else correction.front))
        camera_from_floor = invert_transform(np.array(self.objects.floor_from_camera))
        pixels = project(transform_points(camera_from_floor, points), self.objects.intrinsics)
        if not np.isfinite(pixels).all():
            return []
        return [np.round(pixels[face], 1).tolist() for face in map(list, (*FACES[1:], FACES[0]))]

    def front(self, mask: int, stated: float | None) -> tuple[NDArray[np.float64], float, float] | None:
        """Corners (4, 2) of a thing's front in the picture, its width and height in metres; None: there was no run.

        Args:
            stated: the direction about z that a person says it faces.
        """
        item, placed = self.items.get(mask), self.placed.get(mask)
        if self.objects is None or item is None or item.box is None:
            return None
        camera = np.array(self.objects.floor_from_camera)
        if placed is not None and placed.status == "ok":
            box, facing = UprightBox(placed.position, placed.size, placed.yaw), placed.yaw
        else:
            box = UprightBox(item.box.center, item.box.size, item.box.yaw)
            towards = float(np.arctan2(*(camera[:2, 3] - item.box.center[:2])[::-1]))
            facing = towards if item.front is None else item.front
        points = front_corners(box, facing if stated is None else stated)
        return project(transform_points(invert_transform(camera), points), self.objects.intrinsics), *extents(points)

    def models(self, mask: int) -> list[dict[str, Any]]:
        """Models that can represent an object, nearest first, with pictures as they are placed or would be."""
        entry = self.cousins.get(mask)
        if entry is None or entry.status == "failed":
            return []
        ranks = {cousin.asset: cousin.rank for cousin in entry.cousins}
        nearest = [one for one in entry.by_distance if one.asset not in ranks]
        choosable = [(one.asset, one.distance) for one in entry.cousins]
        choosable = [*choosable, *((one.asset, one.distance) for one in nearest)][:MAX_MODELS]
        placed = self.views.get(mask, {})
        views = {one.asset: one.orientation.yaw for one in entry.cousins} | placed
        other = next(iter((placed or views).values()))
        return [
            {
                "asset": asset,
                "distance": round(distance, 2),
                "rank": ranks.get(asset),
                "size": self.sizes.get(asset),
                "picture": self._picture(asset, views.get(asset, other)),
            }
            for asset, distance in choosable
        ]

    def _picture(self, asset: str, yaw: float) -> str | None:
        view = self.snapshots.picture(asset, yaw)
        if view is None:
            return None
        file = io.BytesIO()
        view.save(file, "PNG")
        return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def hang_on(objects: Objects, wall: Wall, around: tuple[Pixel, Pixel], size: NDArray[np.float64]) -> UprightBox | None:
    """The box on a wall that two opposite corners of its picture show; None: they do not lie on that wall.

    Args:
        size: depth, width and height, metres, as it was placed: it is as deep in proportion.
    """
    camera, normal = np.array(objects.floor_from_camera), np.array(wall.normal)
    pixels = np.array([(x, y, 1.0) for x, _ in around for _, y in around])
    rays = pixels @ np.linalg.inv(objects.intrinsics).T @ camera[:3, :3].T
    reach = (wall.offset - camera[:3, 3] @ normal) / (rays @ normal)
    if not (reach > 0).all():
        return None
    points = camera[:3, 3] + reach[:, None] * rays
    width, height = (float(np.ptp(points @ axis)) for axis in ([-normal[1], normal[0], 0.0], [0.0, 0.0, 1.0]))
    depth = float(size[0] * width / size[1])
    center = (points.min(axis=0) + points.max(axis=0)) / 2 + normal * depth / 2
    return UprightBox(center, [depth, width, height], float(np.arctan2(normal[1], normal[0])))


def read_last_run(results: Path, scene: str, variant: str | None, size: tuple[int, int]) -> LastRun:
    """The results of a scene, as far as they are there.

    Args:
        variant: of matching; None: the first that is there.
        size: width and height of the picture; results of a picture of another size are not used.

    Raises:
        InputError: a file is broken.
    """
    path = results / "extraction" / scene / "objects.json"
    objects = read_json(Objects, path) if path.is_file() else None
    if objects is None or (objects.width, objects.height) != size:
        return LastRun(None, {}, {}, {}, SnapshotShards([]))
    if variant is None:
        found = (path.parent.parent.name for path in (results / "matching").glob(f"*/{scene}/cousins.json"))
        variant = min(found, key=variant_key, default="-")
    path = results / "matching" / variant / scene / "cousins.json"
    matched = read_json(Cousins, path).objects if path.is_file() else []
    place = results / "generation" / variant / scene
    scenes = [read_json(GeneratedScene, path) for path in sorted(place.glob("scene_*.json"))]
    masks = {item.id: item.mask for item in objects.objects}
    return LastRun(
        objects,
        {item.mask: item for item in objects.objects},
        {masks[one.id]: one for one in matched if one.id in masks},
        {masks[one.id]: one for each in scenes if each.rank == 1 for one in each.objects if one.id in masks},
        SnapshotShards(sorted((results / "assets/snapshots").glob("shard_*.h5"))),
        find_picture(place.parents[1], scene, variant),
        _sizes(results / "assets/library/library.json"),
        {mask: views_of(scenes, name) for name, mask in masks.items()},
    )


def find_picture(made: Path, scene: str, variant: str = "*") -> Path | None:
    """A scene's picture of rank 1, of the first variant that has one; `made`: the folder results/generation."""
    found = made.glob(f"{variant}/{scene}/scene_1.png")
    return min(found, key=lambda path: variant_key(path.parts[-3]), default=None)


def _sizes(path: Path) -> dict[str, list[float]]:
    """Width, depth and height, metres, by id."""
    entries = read_json(Library, path).assets if path.is_file() else []
    return {entry.id: [round(entry.size[k], 3) for k in (1, 0, 2)] for entry in entries if entry.size is not None}
