"""Carriers with clutter that nobody named: how high they come out, and what stands on them. One command, no library:

    python -m benchmarks.clutter --rooms 40 --seeds 0 1 2 --out clutter.csv

Each room has a desk, table, coffee table or sideboard before a wall, 0 to 40 % of its top covered by boxes of any
height that its mask shows, and named things between them. Masks are some pixels off, depth errs as in our rooms.
Everything is ray-cast boxes.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from stages.config.extraction import DepthNoiseConfig, ExtractionConfig
from stages.contracts import Annotations
from stages.contracts.objects import USUAL_ERROR
from stages.contracts.scenes import Annotation
from stages.extraction.noise import noisy_depth
from stages.extraction.observation import AnnotatedImage
from stages.extraction.reconstruct import reconstruct
from stages.geometry.boxes import UprightBox
from stages.geometry.cameras import intrinsics_from_fov, look_at
from stages.geometry.frames import yaw_matrix

WIDTH, HEIGHT = 640, 480
FLOOR, WALL, CARRIER = 1, 2, 10
# Depth, width and height of carriers: least and most, metres; and whether there is room for knees beneath.
CARRIERS = {
    "desk": ((0.6, 1.1, 0.7), (0.8, 1.6, 0.78), True),
    "table": ((0.7, 1.0, 0.7), (0.9, 1.6, 0.78), True),
    "coffee table": ((0.45, 0.8, 0.35), (0.6, 1.2, 0.5), True),
    "sideboard": ((0.35, 1.0, 0.6), (0.5, 1.6, 0.9), False),
}
THINGS = {"mug": (0.08, 0.08, 0.1), "book": (0.2, 0.15, 0.04), "box": (0.25, 0.2, 0.18), "laptop": (0.24, 0.34, 0.22)}
COVERED, TALLEST = 0.4, 0.35  # share of a top; metres
OFF = 3  # pixels by which outlines are off, at most
SEEN = 150  # pixels that a thing shows at least, to be asked for
NEAR, SHARE = 0.03, 0.2  # metres, or share of it, within which a height is right


class Room(NamedTuple):
    """Boxes, each with the mask value of what it is part of; labels and true heights by mask value."""

    boxes: list[tuple[UprightBox, int]]
    labels: dict[int, str]
    heights: dict[int, float]
    covered: float


def furnish_carrier(kind: str, rng: np.random.Generator) -> Room:
    """A carrier with clutter and things on it."""
    low, high, hollow = CARRIERS[kind]
    depth, width, height = rng.uniform(low, high)
    yaw, at = rng.uniform(-0.4, 0.4), np.array([rng.uniform(1.8, 3.2), rng.uniform(-0.4, 0.4), 0.0])
    turn = yaw_matrix(yaw)

    def box(x: float, y: float, z: float, size: tuple[float, float, float], turned: float = 0.0) -> UprightBox:
        return UprightBox(at + turn @ [x, y, z + size[2] / 2], size, yaw + turned)

    boxes = [(part, CARRIER) for part in _carrier(box, depth, width, height, hollow)]
    free = np.ones((max(1, int(depth / 0.02)), max(1, int(width / 0.02))), dtype=bool)
    wanted, area = rng.uniform(0, COVERED), depth * width
    labels, heights = {CARRIER: kind}, {CARRIER: height}
    for label in rng.permutation(list(THINGS))[:3]:
        size = THINGS[label]
        spot = _spot(free, size, (depth, width), rng)
        if spot is not None:
            value = CARRIER + len(labels)
            boxes.append((box(*spot, height, size), value))
            labels[value], heights[value] = str(label), size[2]
    covered = 0.0
    for _ in range(60):
        size = (*rng.uniform(0.06, 0.3, 2), rng.uniform(0.02, TALLEST))
        if covered + size[0] * size[1] > wanted * area:
            continue
        spot = _spot(free, size, (depth, width), rng)
        if spot is not None:
            boxes.append((box(*spot, height, size), CARRIER))
            covered += size[0] * size[1]
    return Room(boxes, labels, heights, covered / area)


def _carrier(box, depth: float, width: float, height: float, hollow: bool) -> Iterator[UprightBox]:  # type: ignore[no-untyped-def]
    if not hollow:
        yield box(0, 0, 0, (depth, width, height))
        return
    yield box(0, 0, height - 0.04, (depth, width, 0.04))
    for x in (-1, 1):
        for y in (-1, 1):
            yield box(x * (depth / 2 - 0.03), y * (width / 2 - 0.03), 0, (0.05, 0.05, height - 0.04))


def _spot(
    free: NDArray[np.bool_], size: tuple[float, ...], top: tuple[float, float], rng: np.random.Generator
) -> tuple[float, float] | None:
    """A free place on a top for a thing, from its middle; it is taken then."""
    rows, columns = (int(np.ceil(extent / 0.02)) + 1 for extent in size[:2])
    for _ in range(40):
        if rows > free.shape[0] or columns > free.shape[1]:
            return None
        row, column = rng.integers(free.shape[0] - rows + 1), rng.integers(free.shape[1] - columns + 1)
        if free[row : row + rows, column : column + columns].all():
            free[row : row + rows, column : column + columns] = False
            return (row + rows / 2) * 0.02 - top[0] / 2, (column + columns / 2) * 0.02 - top[1] / 2
    return None


def photograph_room(room: Room, rng: np.random.Generator) -> tuple[AnnotatedImage, NDArray[np.uint16]]:
    """The room through a depth camera with masks some pixels off, and the true masks (H, W)."""
    intrinsics = intrinsics_from_fov(WIDTH, HEIGHT, np.deg2rad(50))
    target = room.boxes[0][0].center
    pose = look_at([0.0, 0.0, rng.uniform(1.2, 1.7)], [target[0], target[1] + rng.uniform(-0.2, 0.2), 0.5])
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(intrinsics).T @ pose[:3, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.where(rays[..., 2] < 0, -pose[2, 3] / rays[..., 2], np.inf)
        wall = np.where(rays[..., 0] > 0, 4.2 / rays[..., 0], np.inf)
    masks = np.where(wall < depth, WALL, FLOOR).astype(np.uint16)
    depth = np.minimum(depth, wall)
    for box, value in room.boxes:
        hit = _hit(pose[:3, 3], rays, box)
        masks[hit < depth] = value
        depth = np.minimum(depth, hit)
    seen = masks.copy()
    for value in rng.permutation(list(room.labels)):
        off = int(rng.integers(-OFF, OFF + 1))
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * abs(off) + 1,) * 2)
        own = (masks == value).astype(np.uint8)
        seen[(seen == value) & ~(cv2.erode(own, kernel) > 0)] = 0 if off < 0 else value
        if off > 0:
            seen[cv2.dilate(own, kernel) > 0] = value
    shown = [value for value in room.labels if (seen == value).sum() >= SEEN and (masks == value).sum() >= SEEN]
    annotations = Annotations(
        objects=[Annotation(mask=value, label=room.labels[value]) for value in shown], floor=FLOOR, walls=[WALL]
    )
    noise = DepthNoiseConfig(scale=0.0)
    depth = noisy_depth(depth.astype(np.float32), noise, rng)
    return AnnotatedImage(
        np.zeros((HEIGHT, WIDTH, 3), np.uint8), depth, seen, intrinsics, annotations, USUAL_ERROR
    ), masks


def _hit(origin: NDArray[np.float64], rays: NDArray[np.float64], box: UprightBox) -> NDArray[np.float64]:
    turn = yaw_matrix(box.yaw)
    start, direction = (origin - np.asarray(box.center)) @ turn, rays @ turn
    with np.errstate(divide="ignore"):
        sides = (np.array([[-0.5], [0.5]]) * np.asarray(box.size) - start)[:, None, None] / direction[None]
    enter, leave = sides.min(axis=0).max(axis=-1), sides.max(axis=0).min(axis=-1)
    return np.asarray(np.where((enter < leave) & (enter > 0), enter, np.inf))


def rows_of(number: int, seed: int) -> Iterator[dict[str, object]]:
    """What came out of one room, a row per thing."""
    rng = np.random.default_rng((seed, number))
    kind = list(CARRIERS)[number % len(CARRIERS)]
    room = furnish_carrier(kind, rng)
    image, _ = photograph_room(room, rng)
    found = reconstruct("room", image, ExtractionConfig(depth_noise="none"), rng).objects.objects
    by_mask = {item.mask: item for item in found}
    carrier = by_mask.get(CARRIER)
    for value, item in by_mask.items():
        height = item.box.size[2] if item.box is not None else np.nan
        true = room.heights[value]
        yield {
            "room": number,
            "seed": seed,
            "covered": round(room.covered, 3),
            "label": item.label,
            "carrier": value == CARRIER,
            "height": round(float(height), 4),
            "true": round(true, 4),
            "supported": value != CARRIER and carrier is not None and item.measured_support == carrier.id,
            "right": bool(abs(height - true) <= max(NEAR, SHARE * true)),
        }


def summary(table: pd.DataFrame) -> str:
    """Errors of carriers' tops, and how much of what stands on them is right."""
    carriers, things = table[table.carrier], table[~table.carrier]
    off = 100 * (carriers.height - carriers.true).abs()
    both = things.supported & things.right
    return (
        f"{len(carriers)} carriers: top off by {off.median():.1f} cm (median), {off.quantile(0.9):.1f} (90 %), "
        f"{off.max():.1f} (most); {len(things)} things: support right {things.supported.mean():.1%}, "
        f"height right {things.right.mean():.1%}, both {both.mean():.1%}"
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", type=int, default=40)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    table = pd.DataFrame(
        [row for seed in asked.seeds for number in range(asked.rooms) for row in rows_of(number, seed)]
    )
    if asked.out:
        table.to_csv(asked.out, index=False)
    for seed, part in table.groupby("seed"):
        print(f"seed {seed}: {summary(part)}")
    print(summary(table))


if __name__ == "__main__":
    main()
