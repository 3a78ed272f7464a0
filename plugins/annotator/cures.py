"""What one click does against a doubt: the words of a button, and the corrections that it says."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.objects import Objects, Wall
from roomkin.stages.contracts.types import FLOOR, WALL
from roomkin.stages.geometry.frames import PointMap
from roomkin.stages.geometry.masks import look_below

NEAR = 0.02  # share of the picture's height within which something lies just below a thing; chosen
APART = 0.3  # metres: a mask whose points lie farther from every wall of the run shows another one; chosen
# text: of a button; of: the mask value whose name follows; set: what it corrects; model: that it rests on
Cure = dict[str, Any]


def find_beneath(masks: NDArray[np.uint16], value: int) -> int | None:
    """What the picture (H, W) shows just below most of a thing; None: not one thing."""
    return look_below(masks, value, range(1, 2 + round(NEAR * len(masks)))) or None


def match_walls(
    objects: Objects, depth: NDArray[np.float32], shown: Mapping[int, NDArray[np.bool_]]
) -> dict[int, Wall]:
    """The wall of a run that each mask of a wall shows, by mask value; `depth`: (H, W) metres; `shown`: (H, W)."""
    seen = PointMap(depth, np.array(objects.intrinsics), np.array(objects.floor_from_camera))

    def distance(points: NDArray[np.float64], wall: Wall) -> float:
        return float(np.median(np.abs(points @ np.array(wall.normal) - wall.offset)))

    found = {}
    for value, mask in shown.items():
        points = seen.of(mask)
        near = [wall for wall in objects.walls if len(points) and distance(points, wall) < APART]
        if near:
            found[value] = min(near, key=partial(distance, points))
    return found


def list_cures(
    doubt: Doubt,
    beneath: Callable[[], int | None],
    walls: Mapping[int, Wall],
    nudged: Sequence[float],
    placed: PlacedObject | None,
    size: Sequence[float] | None,
    room: Mapping[int, str],
) -> list[Cure]:
    """What helps against a doubt, where one click does.

    Args:
        beneath: the mask value of what the picture shows just below the thing.
        walls: by mask value.
        nudged: metres (x, y) by which a person moved the thing before that run.
        placed: the thing in the scene of rank 1.
        size: width, depth and height of the model that stands there, metres.
        room: labels of floor and walls by mask value.
    """
    if DoubtKind.UNNAMED.read(doubt) is not None and (value := beneath()) is not None and room.get(value) != WALL:
        floor = room.get(value) == FLOOR
        return [{"text": "put it on", "of": value, "set": {"on": FLOOR if floor else value}}]
    if (said := DoubtKind.BEHIND_WALL.read(doubt)) is not None:
        by = float(said["depth"]) / 100 + 0.01  # what is said is rounded
        normals = [wall.normal for wall in walls.values() if wall.id == said["wall"]]
        moves = [[round(old + by * new, 3) for old, new in zip(nudged, normal[:2], strict=True)] for normal in normals]
        return [{"text": f"move it {100 * by:.0f} cm, before the wall", "set": {"nudge": move}} for move in moves[:1]]
    if (said := DoubtKind.BEYOND_WALL.read(doubt)) is not None:
        values = [value for value, wall in walls.items() if wall.id == said["wall"]]
        held = [{"mounting": {"type": 1, "walls": [value]}, "on": None} for value in values[:1]]
        return [{"text": "it hangs on", "of": values[0], "set": each} for each in held]
    if DoubtKind.MOUNTING_DIFFERS.read(doubt) is not None:
        return [{"text": "take what geometry finds", "set": {"mounting": None}}]
    if DoubtKind.SURFACE.read(doubt) is not None:
        return [{"text": f"it is {name}", "set": {"label": name}} for name in (FLOOR, WALL)]
    if placed is None or placed.status != "ok":
        return []
    if DoubtKind.NO_FIT.read(doubt) is not None:
        return [{"text": "keep its model", "set": {"model": placed.asset}, "model": placed.asset}]
    if DoubtKind.PLACE_UNSURE.read(doubt) is not None:
        return [{"text": "it stands right", "set": {"nudge": list(nudged)}}]  # what a person says is not doubted
    if doubt.cause == "size":
        depth, width, height = placed.size
        sizes = [("as its model", size), ("keep as placed", (width, depth, height))]
        return [_size_it(words, sides) | {"model": placed.asset} for words, sides in sizes if sides]
    return []


def _size_it(words: str, size: Sequence[float]) -> Cure:
    width, depth, height = (f"{100 * side:.0f}" for side in size)
    text = f"{words}: {width} wide × {depth} deep × {height} high, cm"
    return {"text": text, "set": {"size": [round(side, 3) for side in size]}}
