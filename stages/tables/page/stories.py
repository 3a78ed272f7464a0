"""The story of an object: what was seen, what it was compared with, who chose, where it went, what is doubtful."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from stages.contracts.cousins import Candidate, ObjectCousins
from stages.contracts.doubts import agree, doubts, held_as
from stages.contracts.generated import PlacedObject
from stages.contracts.objects import Objects, SceneObject
from stages.contracts.snapshot_pictures import Snapshots
from stages.geometry.cameras import project
from stages.geometry.frames import apply, inverse, wrap_angle, yaw_matrix
from stages.tables.page.pictures import Album, Picture

SIZE, CANDIDATES, CATEGORIES = 150, 8, 5
POINTS = 5000  # of a cloud, drawn
DIM = 0.3  # of what a mask leaves out
PLACES = {"floor": "on the floor", "wall": "on the wall", "unnamed": "where it was seen, above the floor"}


@dataclass(frozen=True)
class Rival:
    """A model that the object was compared with; `rank` is that of the cousin it became, 0: none."""

    asset: str
    distance: float
    about: str
    rank: int
    picture: Picture | None


@dataclass(frozen=True)
class Story:
    """`pictures` with captions; `facts`: what and how; `rivals`: nearest first, of `compared` models."""

    pictures: list[tuple[Picture, str]]
    facts: list[tuple[str, str]]
    rivals: list[Rival]
    compared: int
    doubts: list[str]


@dataclass(frozen=True)
class Evidence:
    """What the run has of a room: its picture, masks (H, W), clouds by object, and the objects of its first scene."""

    objects: Objects
    rgb: NDArray[np.uint8] | None
    masks: NDArray[np.uint16] | None
    clouds: dict[str, NDArray[np.float32]]
    placed: dict[str, PlacedObject]


def story(entry: ObjectCousins, item: SceneObject, evidence: Evidence, album: Album, snapshots: Snapshots) -> Story:
    """The story of an object that has cousins."""
    placed = evidence.placed.get(entry.id)
    return Story(
        pictures=_pictures(item, evidence, album),
        facts=_facts(entry, item, placed),
        rivals=[_rival(one, entry, album, snapshots) for one in entry.by_distance[:CANDIDATES]],
        compared=len(entry.by_distance),
        doubts=doubts(entry, item, placed, evidence.objects),
    )


def _pictures(item: SceneObject, evidence: Evidence, album: Album) -> list[tuple[Picture, str]]:
    made = []
    if evidence.rgb is not None and evidence.masks is not None and item.pixels is not None:
        made.append((album.put(masked(evidence.rgb, evidence.masks == item.mask), f"Mask of {item.id}", SIZE), "mask"))
    cloud = evidence.clouds.get(item.id)
    if cloud is not None and item.box is not None:
        for flat, name in (((1, 2), "from the front"), ((1, 0), "from above")):
            drawn = drawn_cloud(cloud, item, evidence, flat)
            made.append((album.put(drawn, f"Cloud of {item.id} {name}", SIZE), f"cloud {name}"))
    return made


def masked(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Image.Image:
    """The part of the picture around a mask, all else dimmed."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return Image.fromarray(rgb)
    margin = round(0.1 * max(rows[-1] - rows[0], columns[-1] - columns[0])) + 2
    part = np.s_[max(0, rows[0] - margin) : rows[-1] + margin, max(0, columns[0] - margin) : columns[-1] + margin]
    dimmed = np.where(mask[part][..., None], rgb[part], 255 - DIM * (255 - rgb[part].astype(float)))
    return Image.fromarray(dimmed.astype(np.uint8))


def drawn_cloud(
    cloud: NDArray[np.float32], item: SceneObject, evidence: Evidence, flat: tuple[int, int]
) -> Image.Image:
    """The cloud along two axes of its box, in the picture's colours, and the box around it.

    Args:
        flat: the axes drawn to the right and upwards, of the box seen by the camera: 0 away from it, 1 left, 2 up.
    """
    assert item.box is not None
    some = cloud[np.linspace(0, len(cloud) - 1, min(len(cloud), POINTS)).astype(int)]
    camera = np.array(evidence.objects.floor_from_camera)
    turns = round(wrap_angle(np.arctan2(item.box.center[1], item.box.center[0]) - item.box.yaw) / (np.pi / 2))
    yaw = item.box.yaw + turns * np.pi / 2  # the axis of the box that leads away from the camera most
    local = (some - np.array(item.box.center)) @ yaw_matrix(yaw)
    size = np.array(item.box.size)[[1, 0, 2] if turns % 2 else [0, 1, 2]]
    right, up = flat
    scale = 0.44 * SIZE / max(size[[right, up]].max() / 2, 1e-3)
    pixels = SIZE / 2 + scale * np.column_stack([-local[:, right], -local[:, up]])  # y is left: mirrored to the right
    canvas = np.full((SIZE, SIZE, 3), 250, dtype=np.uint8)
    colours = _colours(some, camera, evidence)
    for dot in ((0, 0), (0, 1), (1, 0), (1, 1)):
        at = pixels.astype(int) + dot
        inside = ((at >= 0) & (at < SIZE)).all(axis=1)
        canvas[at[inside, 1], at[inside, 0]] = colours[inside]
    image = Image.fromarray(canvas)
    half = scale * size[[right, up]] / 2
    corners = [SIZE / 2 - half[0], SIZE / 2 - half[1], SIZE / 2 + half[0], SIZE / 2 + half[1]]
    ImageDraw.Draw(image).rectangle(corners, outline=(200, 90, 40))
    return image


def _colours(points: NDArray[np.float32], camera: NDArray[np.float64], evidence: Evidence) -> NDArray[np.uint8]:
    """Of the pixels that show the points; grey without a picture."""
    if evidence.rgb is None:
        return np.full((len(points), 3), 110, dtype=np.uint8)
    height, width = evidence.rgb.shape[:2]
    at = (
        np.nan_to_num(project(apply(inverse(camera), points), np.array(evidence.objects.intrinsics)))
        .round()
        .astype(int)
    )
    columns, rows = at[:, 0].clip(0, width - 1), at[:, 1].clip(0, height - 1)
    found: NDArray[np.uint8] = evidence.rgb[rows, columns]
    return found


def _facts(entry: ObjectCousins, item: SceneObject, placed: PlacedObject | None) -> list[tuple[str, str]]:
    facts = [("seen", f"label “{item.label}”, {item.points:,} points in its cloud")]
    if item.box is not None:
        facts.append(("box of the cloud", _metres(item.box.size)))
    if item.mounting is not None:
        facts.append(("mounting", _mounting(item)))
    if item.support is not None:
        facts.append(("stands", f"{PLACES.get(item.support, f'on {item.support}')}, as a person says"))
    if entry.categories:
        told = [f"{one.category.replace('_', ' ')} {one.distance:.2f}" for one in entry.categories[:CATEGORIES]]
        more = len(entry.categories) - CATEGORIES
        facts.append(
            ("categories, by distance of the label", ", ".join(told) + (f" and {more} more" if more > 0 else ""))
        )
    if entry.decided_by:
        facts.append(("model chosen by", entry.decided_by))
    if entry.orientation_decided_by:
        turn = f", turned by {np.degrees(entry.cousins[0].orientation.yaw):.0f}° in the camera's view"
        facts.append(("orientation chosen by", entry.orientation_decided_by + turn))
    if placed is not None and placed.status == "ok":
        on = PLACES.get(placed.support, f"on {placed.support}")
        place = (
            f"{placed.asset.replace('_', ' ')} {on}, {_metres(placed.size)}, turned by {np.degrees(placed.yaw):.0f}°"
        )
        facts.append(("placed", place))
        facts += [("then" if number else "how", what) for number, what in enumerate(placed.steps)]
    return facts


def _mounting(item: SceneObject) -> str:
    """How it is held, and whether the input and geometry agree on it."""
    assert item.mounting is not None
    if item.measured_mounting is None:
        return held_as(item.mounting) + ", by geometry"
    agreed = "geometry agrees" if agree(item) else f"geometry finds: {held_as(item.measured_mounting)}"
    whose = "a person" if "mounting" in item.told else "the input"
    return f"{held_as(item.mounting)}, as {whose} says; {agreed}"


def _rival(one: Candidate, entry: ObjectCousins, album: Album, snapshots: Snapshots) -> Rival:
    ranks = {cousin.asset: cousin.rank for cousin in entry.cousins}
    about = [f"score {one.score:.2f}"] if one.score is not None else []
    about += [f"{name} {value:.2f}" for name, value in (one.terms or one.parts).items()]
    about += [f"{one.votes} votes"] if one.votes is not None else []
    view = snapshots.picture(one.asset)
    picture = album.put(view, f"{one.asset}, compared with {entry.id}", SIZE // 2) if view else None
    return Rival(one.asset, one.distance, ", ".join(about), ranks.get(one.asset, 0), picture)


def _metres(size: tuple[float, float, float]) -> str:
    return " × ".join(f"{length:.2f}" for length in size) + " m"
