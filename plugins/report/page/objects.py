"""An object of a picture: what was seen, what it was compared with, who chose its cousins, and what is in doubt."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from roomkin.plugins.report.album import THUMBNAIL, Album, PagePicture, SnapshotShards
from roomkin.plugins.report.doubts import collect_doubts, collect_notes
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.objects import Objects, SceneObject
from roomkin.stages.geometry.frames import invert_transform, project, transform_points, wrap_angle, yaw_matrix
from roomkin.stages.tables.text import NOTHING

LISTED = 5  # cousins, models compared and categories of an object that are listed
Pixels = NDArray[np.uint8]


class Match(NamedTuple):
    """One object of the picture and the cousins found for it.

    measure: what put its cousins in order; empty: it has no numbers. cousins: each with the number by which it was
    ranked (empty: there is none). pictures: mask and cloud, with captions. rivals: the nearest models that it was
    compared with.
    """

    entry: ObjectCousins
    item: SceneObject
    placed: PlacedObject | None
    measure: str
    picture: PagePicture | None
    cousins: list[tuple[Cousin, str, PagePicture | None]]
    pictures: list[tuple[PagePicture, str]]
    rivals: list[tuple[Candidate, PagePicture | None]]
    doubts: list[Doubt]
    notes: list[str]


@dataclass(frozen=True)
class RoomResults:
    """The results about a room: its picture, masks (H, W), clouds by object, the objects of its first scene, and the
    views of models that stand for them in any (`views_of`)."""

    objects: Objects
    rgb: Pixels | None
    masks: NDArray[np.uint16] | None
    clouds: dict[str, NDArray[np.float32]]
    placed: dict[str, PlacedObject]
    views: dict[str, dict[str, float]] = field(default_factory=dict)


def match(
    entry: ObjectCousins, item: SceneObject, evidence: RoomResults, album: Album, snapshots: SnapshotShards
) -> Match:
    """An object that has cousins."""
    placed, listed, views = evidence.placed.get(entry.id), entry.cousins[:LISTED], evidence.views.get(entry.id, {})
    measure, numbers = explain_order(entry.decided_by, listed)
    seen = Image.fromarray(crop_object(evidence.rgb, item)) if evidence.rgb is not None else None

    def thumbnail(model: Cousin | Candidate, alt: str, yaw: float | None = None) -> PagePicture | None:
        return album.thumbnail(snapshots.picture(model.asset, yaw), f"{model.asset}, {alt} {entry.id}")

    return Match(
        entry=entry,
        item=item,
        placed=placed,
        measure=measure,
        picture=album.thumbnail(seen, f"{entry.id} in the input"),
        cousins=[
            (one, number, thumbnail(one, "cousin of", views.get(one.asset, one.orientation.yaw)))
            for one, number in zip(listed, numbers, strict=True)
        ],
        pictures=list(_pictures(item, evidence, album)),
        rivals=[(one, thumbnail(one, "compared with")) for one in entry.by_distance[:LISTED]],
        doubts=collect_doubts(entry, item, placed, evidence.objects),
        notes=collect_notes(entry, item, placed),
    )


def explain_order(decided_by: str, cousins: list[Cousin]) -> tuple[str, list[str]]:
    """How cousins were ranked, in words, and the number of each."""
    if cousins and not cousins[0].fits:
        return "no model fits, so no numbers: by name, doors and drawers, size and place", [""] * len(cousins)
    if cousins and all(cousin.score is not None for cousin in cousins):
        scores = [cousin.score or 0.0 for cousin in cousins]
        alike = "" if scores == sorted(scores, reverse=True) else "; alike objects are ordered by its mean"
        return f"fit by {decided_by}: more is better{alike}", [f"{score:.2f}" for score in scores]
    if decided_by == "votes":
        return "votes: more is better", [NOTHING if cousin.votes is None else str(cousin.votes) for cousin in cousins]
    if decided_by == "distance":
        return "distance of features: less is better", [f"{cousin.distance:.2f}" for cousin in cousins]
    return "", [""] * len(cousins)


def _pictures(item: SceneObject, evidence: RoomResults, album: Album) -> Iterator[tuple[PagePicture, str]]:
    if evidence.rgb is not None and evidence.masks is not None:
        picture = Image.fromarray(crop_object(fade_background(evidence.rgb, evidence.masks == item.mask), item))
        yield album.thumbnail(picture, f"Mask of {item.id}"), "mask"  # type: ignore[misc]
    cloud = evidence.clouds.get(item.id)
    if cloud is not None and item.box is not None:
        for axes, name in (((1, 2), "from the front"), ((1, 0), "from above")):
            picture = cloud_picture(cloud, item, evidence, axes)
            yield album.put(picture, f"Cloud of {item.id} {name}"), f"cloud {name}"


def crop_object(rgb: Pixels, item: SceneObject) -> Pixels:
    """The object's part of the picture, with a margin; the whole picture if its place is unknown."""
    if item.pixels is None:
        return rgb
    x0, y0, x1, y1 = item.pixels
    margin = max(x1 - x0, y1 - y0) // 10
    return rgb[max(0, y0 - margin) : y1 + margin, max(0, x0 - margin) : x1 + margin]


def fade_background(rgb: Pixels, mask: NDArray[np.bool_]) -> Pixels:
    """The picture, faded half-way to white outside the mask."""
    return np.where(mask[..., None], rgb, (rgb.astype(np.uint16) + 255) // 2).astype(np.uint8)


def cloud_picture(
    cloud: NDArray[np.float32], item: SceneObject, evidence: RoomResults, axes: tuple[int, int]
) -> Image.Image:
    """The cloud in the picture's colors and its box, as the camera sees them.

    Args:
        axes: those drawn to the right and upwards, of the box as the camera sees it: 0 away from it, 1 left, 2 up.
    """
    assert item.box is not None
    x, y, _ = item.box.center
    quarters = round(wrap_angle(np.arctan2(y, x) - item.box.yaw) / (np.pi / 2))
    turn = yaw_matrix(item.box.yaw + quarters * np.pi / 2)  # the first axis leads away from the camera
    size = np.array(item.box.size)[[1, 0, 2] if quarters % 2 else [0, 1, 2]][list(axes)]
    scale = 0.88 * THUMBNAIL / max(size.max(), 1e-3)
    local = ((cloud - np.array(item.box.center)) @ turn)[:, axes]
    pixels = (THUMBNAIL / 2 - scale * local).astype(int)  # left and up count from the right and lower edge
    inside = ((pixels >= 0) & (pixels < THUMBNAIL)).all(axis=1)
    canvas = np.full((THUMBNAIL, THUMBNAIL, 3), 255, dtype=np.uint8)
    canvas[pixels[inside, 1], pixels[inside, 0]] = _color_points(cloud, evidence)[inside]
    picture = Image.fromarray(canvas)
    low, high = (THUMBNAIL + sign * scale * size for sign in (-1, 1))
    ImageDraw.Draw(picture).rectangle([*(low / 2), *(high / 2)], outline="orangered")
    return picture


def _color_points(points: NDArray[np.float32], evidence: RoomResults) -> Pixels:
    """Of the pixels that show the points; grey without a picture."""
    if evidence.rgb is None:
        return np.full((len(points), 3), 110, dtype=np.uint8)
    objects = evidence.objects
    camera_from_floor = invert_transform(np.array(objects.floor_from_camera))
    seen = project(transform_points(camera_from_floor, points), np.array(objects.intrinsics))
    columns, rows = np.nan_to_num(seen).round().astype(int).T
    return evidence.rgb[rows.clip(0, objects.height - 1), columns.clip(0, objects.width - 1)]


def measure_extents(item: SceneObject) -> tuple[float, float, float]:
    """Depth, width and height of its box, from its front, or from the camera where nobody says what it faces."""
    assert item.box is not None
    x, y, _ = item.box.center
    towards = np.arctan2(-y, -x) if item.front is None else item.front
    across, along, height = item.box.size
    turned = round((towards - item.box.yaw) / (np.pi / 2)) % 2
    return (along, across, height) if turned else (across, along, height)
