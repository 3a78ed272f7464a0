"""Walls of a room by lines on the floor, by what stands against them and by the usual sizes of what hangs on them."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.types import Pixel
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.perception.camera.metrology import FLAT_DEPTH, PinholeView, UprightPlane, hang_box
from roomkin.stages.perception.camera.perspective import find_segments
from roomkin.stages.perception.layout.ends import WALL, Kind, Mask

Array = NDArray[np.float64]
STEP = 0.02  # metres between offsets that are tried
FARTHEST = 10.0  # metres to a wall
TOUCH, ON_LINE, HUNG = 0.15, 0.06, 0.25  # deviations: metres, metres, logarithm; chosen
BEHIND = 0.25  # metres by which a box may be wrong, and reach behind a wall; chosen
MIN_VOTE = 1.2  # least sum of votes for a wall; chosen
LEAST_LINE = 0.06  # of the picture's width: length of a line on the floor that tells of a wall; chosen
NORMALS = np.array([(0.0, -1, 0), (1, 0, 0), (-1, 0, 0)])  # of the walls: the far one, that to the left, to the right
WITHIN = 0.25  # of the length that was drawn of a wall, by which another one may cut it off
AGAINST = {"appliance", "bed", "storage"}  # kinds that stand against walls: a vote each


def find_wall(
    view: PinholeView,
    normal: Array,
    boxes: Sequence[UprightBox],
    against: Sequence[bool],
    segments: Array,
    far: Sequence[float],
) -> UprightPlane | None:
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
    return UprightPlane(normal, -float(offsets[best])) if far or votes[best] >= MIN_VOTE else None


def measure_rectangle(view: PinholeView, wall: UprightPlane, mask: Mask) -> tuple[float, Array]:
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


def hang_things(
    rgb: NDArray[np.uint8],
    view: PinholeView,
    masks: NDArray[np.integer],
    kinds: Mapping[int, Kind],
    on: Mapping[int, int],
    boxes: Mapping[int, UprightBox],
) -> tuple[list[UprightPlane], dict[int, UprightBox], dict[int, int]]:
    """The walls of a room; boxes of what hangs on them, and on which: -1 - k for wall k.

    Args:
        masks: (H, W).
        kinds, on: what each thing is, and what carries it, by the values of masks.
        boxes: of what stands, likewise.
    """
    segments = list_free_segments(rgb, masks, list(on))
    sides, hung = [UprightPlane(normal, -1.0) for normal in NORMALS], [value for value in on if on[value] == WALL]
    rectangles = {value: [measure_rectangle(view, side, masks == value) for side in sides] for value in hung}
    facing = {value: int(np.argmax([share for share, _ in found])) for value, found in rectangles.items()}
    against = [bool(AGAINST & kinds[value].kin) for value in boxes]
    walls, hanging, holders = [], {}, {}
    for number, normal in enumerate(NORMALS):
        at_one = {value: found[number][1] for value, found in rectangles.items() if facing[value] == number}
        at_one = {value: ends for value, ends in at_one.items() if np.ptp(ends[:, 0]) > 0}
        far = [float(np.exp(kinds[value].usual.mean[0]) / np.ptp(ends[:, 0])) for value, ends in at_one.items()]
        wall = find_wall(view, normal, list(boxes.values()), against, segments, far)
        if wall is None:
            continue
        walls.append(wall)
        for value, ends in at_one.items():  # as far from the camera as the wall is
            (along, above), (width, height) = ends.mean(axis=0), np.maximum(np.ptp(ends, axis=0) * -wall.offset, 0.01)
            middle = along * -wall.offset, view.above + (above - view.above) * -wall.offset
            size = float(width), kinds[value].depth or FLAT_DEPTH, float(height)
            hanging[value] = hang_box(wall, float(middle[0]), float(middle[1]), size)
            holders[value] = -len(walls)
    return walls, hanging, holders


def list_free_segments(rgb: NDArray[np.uint8], masks: NDArray[np.integer], values: list[int]) -> Array:
    """Lines (N, 2, 2) of a picture that no thing shows."""
    things = cv2.dilate(np.isin(masks, values).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    segments = find_segments(rgb)
    height, width = masks.shape
    samples = segments[:, :1] + np.linspace(0, 1, 9)[:, None] * (segments[:, 1:] - segments[:, :1])
    x, y = np.rint(samples).astype(int).transpose(2, 0, 1)
    covered = things[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)].mean(axis=1)
    return np.asarray(segments[covered < 0.3])


def cut_off(wall: UprightPlane, drawn: tuple[float, float], others: list[UprightPlane]) -> UprightPlane:
    """The wall with its ends where it meets others.

    Args:
        drawn: the stretch along the wall where its base was drawn; a wall that crosses it in the middle cuts nothing
        off.
    """
    (first, last), (low, high) = sorted(drawn), wall.ends
    slack = WITHIN * (last - first)
    for other in others:
        across = float(wall.along @ other.normal)
        if abs(across) < 0.1:
            continue
        at = (other.offset - wall.offset * float(wall.normal @ other.normal)) / across
        if at > last - slack:
            high = min(high, at)
        elif at < first + slack:
            low = max(low, at)
    return UprightPlane(wall.normal, wall.offset, (low, high))


def end_walls(
    view: PinholeView, walls: Mapping[str, UprightPlane], drawn: Mapping[str, tuple[Pixel, Pixel]]
) -> dict[str, UprightPlane]:
    """The walls as far as they reach, by their ids; `drawn`: the lines of their feet."""
    found = {}
    for name, line in drawn.items():
        if name in walls:
            wall, others = walls[name], [other for key, other in walls.items() if key != name]
            first, last = (float(view.meet_level(end) @ wall.along) for end in line)
            found[name] = cut_off(wall, (first, last), others)
    return found
