"""What is right about a thing, and how it may be called: one definition for the tables and for submissions."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from roomkin.plugins.scorecard.truth import TrueHandle, TrueThing
from roomkin.stages.contracts.generated import RIGHT_MIN, RIGHT_SHARE
from roomkin.stages.contracts.parts import HingeSide
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import angle_difference, wrap_angle, yaw_matrix


@dataclass(frozen=True)
class ThingNames:
    """What people call such a thing, the categories of our library that are sensible cousins of it, its symmetry."""

    labels: list[str]
    sensible: list[str]
    turn: str


@cache
def stated_kinds() -> dict[str, ThingNames]:
    """The table of kinds.yaml."""
    rows = yaml.safe_load(Path(__file__).with_name("kinds.yaml").read_text(encoding="utf-8"))
    return {name: ThingNames(**fields) for name, fields in rows.items()}


def plain_name(name: str) -> str:
    """A name in small letters, words apart by one space, without a number at its end: `Office_Chair_2`."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])|[\W_]+", " ", name).casefold().split()
    return " ".join(words[:-1] if len(words) > 1 and words[-1].isdigit() else words)


def is_sensible(name: str, kind: str) -> bool:
    """Whether a thing of a kind may be called so: by its kind, a label of it, or a category that is its cousin."""
    known = stated_kinds()[kind]
    return plain_name(name) in {plain_name(word) for word in (kind, *known.labels, *known.sensible)}


PLACE = 0.05  # metres between true and found center, and between a true handle's box and a point on the found one
YAW = np.deg2rad(15)
FACING = 45  # degrees, modulo the thing's symmetry, within which a thing faces where it should
MAX_BEHIND = 0.10  # metres behind a wall


def size_errors(true: TrueThing, size: tuple[float, float, float], yaw: float) -> NDArray[np.float64]:
    """Placed less true extents (3,), metres, along the true thing's axes as nearly as a box can tell."""
    ours, truth = np.array(size), np.array(true.size)
    if true.symmetry == "full":
        return np.array([*(np.sort(ours[:2]) - np.sort(truth[:2])), ours[2] - truth[2]])
    quarters = round(wrap_angle(yaw - true.yaw) / (np.pi / 2))
    return np.asarray((ours[[1, 0, 2]] if quarters % 2 else ours) - truth)


def is_size_right(errors: NDArray[np.float64], truth: tuple[float, float, float]) -> bool:
    """Whether every extent is within 10 % or 3 cm."""
    return bool((np.abs(errors) <= np.maximum(RIGHT_SHARE * np.array(truth), RIGHT_MIN)).all())


def measure_turn(true: TrueThing, yaw: float) -> float | None:
    """Radians between a yaw and the true one; None: the thing is round, so that none is asked."""
    return None if true.symmetry == "full" else angle_difference(yaw, true.yaw, true.symmetry)


def measure_overreach(box: UprightBox, room: tuple[float, float]) -> float:
    """How far a box reaches behind the walls of a room, metres."""
    points = corners(box)[:, :2]
    return float(max((points - np.array(room)).max(), (-points).max(), 0.0))


def are_handles_right(thing: TrueThing, points: NDArray[np.float64]) -> bool | None:
    """Whether every door and drawer has a handle of its own among the points (N, 3), and no point is at none; None:
    where the handles are is not known."""
    if not thing.handles:
        return None
    off = np.array([measure_distances(thing.box, handle, points) for handle in thing.handles]) <= PLACE
    panels = np.array([handle.panel for handle in thing.handles])
    of_panel = np.array([off[panels == panel].any(axis=0) for panel in np.unique(panels)])
    rows, columns = linear_sum_assignment(of_panel, maximize=True)
    return bool(of_panel[rows, columns].sum() == len(of_panel) and off.any(axis=0).all())


def measure_distances(box: UprightBox, handle: TrueHandle, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Metres of points (N, 3) to the box of a handle of what stands in `box`."""
    own = (points - box.center) @ yaw_matrix(box.yaw)
    beyond = np.abs(own - np.array(handle.position)) - np.array(handle.size) / 2
    return np.asarray(np.linalg.norm(np.maximum(beyond, 0), axis=1))


def knows_hinges(opens: tuple[str, ...]) -> bool:
    """Whether something opens, and how is known."""
    return bool(opens) and set(opens) <= set(get_args(HingeSide))
