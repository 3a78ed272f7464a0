"""Walls of a room by lines on the floor, by what stands against them and by the usual sizes of what hangs on them."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.inputs.photo.metrology import View, WallPlane
from plugins.single_view.ends import Mask
from stages.geometry.boxes import UprightBox, corners

Array = NDArray[np.float64]
STEP = 0.02  # metres between offsets that are tried
FARTHEST = 10.0  # metres to a wall
TOUCH, ON_LINE, HUNG = 0.15, 0.06, 0.25  # deviations: metres, metres, logarithm; chosen
BEHIND = 0.25  # metres by which a box may be wrong, and reach behind a wall; chosen
MIN_VOTE = 1.2  # least sum of votes for a wall; chosen
LEAST_LINE = 0.06  # of the picture's width: length of a line on the floor that tells of a wall; chosen
AGAINST = {"appliance", "bed", "storage"}  # kinds that stand against walls: a vote each


def find_wall(
    view: View,
    normal: Array,
    boxes: Sequence[UprightBox],
    against: Sequence[bool],
    segments: Array,
    far: Sequence[float],
) -> WallPlane | None:
    """The wall that looks along `normal`, if enough tells of one.

    Args:
        boxes: of all that stands, in the room.
        against: whether each is of a kind that stands against walls.
        segments: lines (N, 2, 2) of the picture outside of things.
        far: how far before the camera each hung thing would be by its usual size, metres.
    """
    offsets = np.arange(0.5, FARTHEST, STEP)
    furniture, lines, hung, before = (np.zeros(len(offsets)) for _ in range(4))
    for box, is_against in zip(boxes, against, strict=True):
        rear = float((corners(box) @ -normal).max())
        if is_against and rear > 0:
            furniture += np.exp(-(((offsets - rear) / (TOUCH + 0.05 * rear)) ** 2) / 2)
        before += rear > offsets + BEHIND + 0.05 * rear
    for ends in segments:
        length = float(np.linalg.norm(ends[1] - ends[0])) / view.width
        rays = view.rays(ends)
        if length < LEAST_LINE or (rays[:, 2] > -0.02).any():
            continue
        feet = rays * (view.above / -rays[:, 2])[:, None]
        at = feet @ -normal
        along = np.ptp(feet @ np.array([-normal[1], normal[0], 0]))
        if at.min() > 0.3 and np.ptp(at) < 0.1 * along:
            vote = min(1.0, 4 * length) * np.exp(-(((offsets - at.mean()) / (ON_LINE * at.mean())) ** 2) / 2)
            lines = np.maximum(lines, vote)
    for one in far:
        hung += 0.4 * np.exp(-((np.log(offsets / one) / HUNG) ** 2) / 2)
    votes = np.minimum(furniture, 2) + lines + np.minimum(hung, 1) - before
    best = int(votes.argmax())
    return WallPlane(normal, -float(offsets[best])) if far or votes[best] >= MIN_VOTE else None


def measure_rectangle(view: View, wall: WallPlane, mask: Mask) -> tuple[float, Array]:
    """How much of the upright rectangle around a mask (H, W), laid on a wall, it fills; and that rectangle's ends.

    The ends are along the wall and in height: (2, 2), metres.
    """
    curves, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    curve = max(curves, key=cv2.contourArea)[:, 0].astype(float)
    rays = view.rays(curve)
    towards = rays @ wall.normal
    if (towards > -1e-3).any():
        return 0.0, np.zeros((2, 2))
    points = rays * (wall.offset / towards)[:, None] + [0, 0, view.above]
    flat = np.stack([points @ wall.along, points[:, 2]], axis=1)
    ends = np.array([flat.min(axis=0), flat.max(axis=0)])
    area = cv2.contourArea(flat.astype(np.float32)[:, None])
    return float(area / max(1e-9, np.prod(ends[1] - ends[0]))), ends
