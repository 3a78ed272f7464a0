"""Submitted things in the world of the truth, each beside the true one that it stands for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from roomkin.plugins.scorecard.truth import PictureTruth, SubmittedRoom, TrueThing
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import invert_transform, transform_points, wrap_angle, yaw_of_matrix

NEAR, LEAST = 0.5, 0.15  # of the true box's diagonal, metres: centers farther apart are of two things; chosen
ALIKE = 3.0  # times the true box's diagonal, or a part of it: what is larger or smaller is another thing; chosen


def pair_things(
    asked: Sequence[TrueThing], boxes: Sequence[UprightBox], numbers: Sequence[int | None]
) -> Mapping[int, int]:
    """The place of the submitted thing of each true one, by number; one for one, the nearest over all.

    Names play no part: a thing with a wrong name is placed, and not sensible.

    Args:
        asked: true things.
        boxes: submitted ones, in the world.
        numbers: mask value of each; None: by its place alone.
    """
    told = {number: place for place, number in enumerate(numbers) if number is not None}
    found = {thing.number: told[thing.number] for thing in asked if thing.number in told}
    left = [thing for thing in asked if thing.number not in found]
    free = [place for place, number in enumerate(numbers) if number is None]
    if not left or not free:
        return found
    diagonals = np.array([np.linalg.norm(thing.size) for thing in left])
    gate = np.maximum(LEAST, NEAR * diagonals)
    centers = np.array([boxes[place].center for place in free])
    apart = np.linalg.norm(np.array([thing.position for thing in left])[:, None] - centers, axis=2)
    ratio = np.log(np.array([np.linalg.norm(boxes[place].size) for place in free]) / diagonals[:, None])
    gain = np.where(np.abs(ratio) <= np.log(ALIKE), np.clip(1 - apart / gate[:, None], 0, None), 0)
    rows, columns = linear_sum_assignment(gain, maximize=True)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return found | {left[row].number: free[column] for row, column in pairs if gain[row, column] > 0}


ROUNDS = 3  # of finding one scale and pairing by it


@dataclass(frozen=True)
class PlacedRoom:
    """Boxes, and points on handles (N, 3), of a submission in the world; by number, the place of each true thing's."""

    boxes: list[UprightBox]
    handles: list[NDArray[np.float64]]
    pairs: Mapping[int, int]
    scale: float


def world_from(room: SubmittedRoom, truth: PictureTruth) -> NDArray[np.float64]:
    """Transform (4, 4) of the submission's frame to the world, through the camera."""
    if room.floor_from_camera is None:
        return truth.pose
    return np.asarray(truth.pose @ invert_transform(room.floor_from_camera))


def place_room(room: SubmittedRoom, truth: PictureTruth, asked: Sequence[TrueThing]) -> PlacedRoom:
    """The submission in the world, paired with the truth.

    A yaw is one about the vertical of the submission's frame; a floor found a little tilted moves boxes, but does not
    tilt them. In the camera's frame it counts from the camera's x axis, laid level.
    """
    transform = world_from(room, truth)
    turn = yaw_of_matrix(transform[:3, :3])
    boxes = [
        UprightBox(transform_points(transform, thing.center), thing.size, wrap_angle(thing.yaw + turn))
        for thing in room.things
    ]
    handles = [transform_points(transform, np.reshape(thing.handles, (-1, 3))) for thing in room.things]
    numbers = [thing.number for thing in room.things]
    eye, scale = truth.pose[:3, 3], 1.0
    pairs = pair_things(asked, boxes, numbers)
    if room.scale == "free" and boxes:
        scale = _guess_scale(boxes, asked, eye) if not pairs or None in numbers else 1.0
        for _ in range(ROUNDS):
            pairs = pair_things(asked, [_resize(box, eye, scale) for box in boxes], numbers)
            scale = find_scale(asked, boxes, pairs, eye) or scale
        boxes = [_resize(box, eye, scale) for box in boxes]
        handles = [eye + scale * (points - eye) for points in handles]
        pairs = pair_things(asked, boxes, numbers)
    return PlacedRoom(boxes, handles, pairs, scale)


def find_scale(
    asked: Sequence[TrueThing], boxes: Sequence[UprightBox], pairs: Mapping[int, int], eye: NDArray[np.float64]
) -> float | None:
    """True over found distances from the camera, the median of what is paired; None: nothing is."""
    there = [thing for thing in asked if thing.number in pairs]
    true = [float(np.linalg.norm(thing.position - eye)) for thing in there]
    found = [float(np.linalg.norm(boxes[pairs[thing.number]].center - eye)) for thing in there]
    ratios = [one / max(other, 1e-6) for one, other in zip(true, found, strict=True)]
    return float(np.median(ratios)) if ratios else None


def _guess_scale(boxes: Sequence[UprightBox], asked: Sequence[TrueThing], eye: NDArray[np.float64]) -> float:
    """The ratio of median distances, before anything is paired."""
    true = [float(np.linalg.norm(thing.position - eye)) for thing in asked] or [1.0]
    found = [float(np.linalg.norm(box.center - eye)) for box in boxes]
    return float(np.median(true)) / max(float(np.median(found)), 1e-6)


def _resize(box: UprightBox, eye: NDArray[np.float64], scale: float) -> UprightBox:
    return UprightBox(eye + scale * (box.center - eye), scale * box.size, box.yaw)
