"""The floor frame of a picture, given or fitted, the walls of its room (paper A.3), doubts of the camera's height."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.categories import sizes_of
from roomkin.stages.contracts.category import USUAL_SPREAD
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.images import DEPTH_UNITS, check_turned
from roomkin.stages.contracts.objects import SceneObject, Wall
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.geometry import room_planes
from roomkin.stages.geometry.frames import Array, PointMap
from roomkin.stages.geometry.levels import find_floor
from roomkin.stages.geometry.masks import erode
from roomkin.stages.geometry.room_planes import SAME_DIRECTION, Plane

LOWEST, HIGHEST = DoubtKind.CAMERA_HEIGHT.bounds
# What makes a camera seem higher, or lower, than it is, and by what its height is to be multiplied then.
TOO_HIGH = {"depth in feet": 0.3048, "intrinsics of half the picture's size": 0.5, "depth in decimetres": 0.1}
TOO_LOW = {"depth in centimetres, taken for millimetres": 10.0, "intrinsics of twice the picture's size": 2.0}


def doubt_height(height: float) -> str:
    """A warning about a camera's height over the floor, metres, and which mistakes make such a height; empty: none.

    Depth of 8 bits has steps of no known size: it is named wherever the camera is too low.
    """
    if LOWEST <= height <= HIGHEST:
        return ""
    causes = TOO_HIGH if height > HIGHEST else TOO_LOW
    found = [f"{name} ({height * by:.2f} m)" for name, by in causes.items() if LOWEST <= height * by <= HIGHEST]
    found += ["depth of 8 bits, whose steps are no millimetres"] if height < LOWEST else []
    why = f" if it is not, these would make it so: {', '.join(found)}" if found else ""
    return f"the camera is {height:.2f} m above the floor: is that so?{why}"


def doubt_unit(items: Iterable[SceneObject]) -> str:
    """A warning that things are too large or small by one factor, with the unit of depth that mends it; empty: none.

    It takes two things at least, of which most are unusual as they are, and all usual with the median of what would
    make each as high as its category is.
    """
    ranges = []
    for item in items:
        heights = sizes_of(item.label)[:, 2]
        if item.box is not None and len(heights):
            ranges.append(np.log([heights.min(), heights.max()]) - np.log(item.box.size[2]))
    if len(ranges) < 2:
        return ""
    factor = float(np.median(np.mean(ranges, axis=1)))
    unusual = sum(not low - USUAL_SPREAD <= 0 <= high + USUAL_SPREAD for low, high in ranges)
    fitting = sum(low - USUAL_SPREAD <= factor <= high + USUAL_SPREAD for low, high in ranges)
    if 2 * unusual <= len(ranges) or fitting < len(ranges) or abs(factor) < USUAL_SPREAD:
        return ""
    times = float(np.exp(factor))
    unit = min(DEPTH_UNITS, key=lambda one: abs(np.log(one / (1000 / times))))
    fits = f"{unit:g}" if abs(np.log(unit * times / 1000)) < USUAL_SPREAD / 2 else f"{float(f'{1000 / times:.2g}'):g}"
    much, what = (times, "small") if times > 1 else (1 / times, "large")
    told = f"{unusual} of {len(ranges)} things are {much:.1f} times too {what}"
    return f"{told}: --unit {fits} if depth was read as mm, {float(fits) / 1000:g} if as m"


ROUGH = 0.05  # share of the distance by which neighbouring pixels differ in the median: no room is so rough; chosen
MOST_OFF = 0.2  # share of the camera's height by which a given frame errs at most; chosen
MOST_LEANING = 45.0  # degrees, likewise, where no mask shows the floor: surfaces may lean; chosen


def check_smooth(depth: NDArray[np.floating]) -> None:
    """Refuse depth (H, W) whose neighbouring pixels have nothing to do with each other.

    Raises:
        InputError: it is noise.
    """
    known = (depth[:, 1:] > 0) & (depth[:, :-1] > 0)
    steps = np.abs(np.diff(depth, axis=1))[known] / depth[:, 1:][known]
    if len(steps) and (rough := float(np.median(steps))) > ROUGH:
        what = f"is noise: neighbouring pixels differ by {100 * rough:.0f} % in the median."
        fix = "give depth of this picture, unpacked as its camera says"
        raise InputError("depth.npz", what, fix, code="E-DEPTH-NOISE")


def find_floor_frame(image: AnnotatedImage, seen: PointMap, max_tilt: float, rng: np.random.Generator) -> Array:
    """`floor_from_camera` (4, 4): as given, else from the floor's mask, else from the level planes.

    It prints where the floor was found without a mask, and a doubtful height of the camera.

    Args:
        seen: what is used of the picture, camera frame.
        max_tilt: largest angle between image-up and the floor's normal, degrees.

    Raises:
        InputError: depth is noise, no floor is seen, or it is not where the given frame says.
    """
    check_smooth(image.depth)
    frame = image.floor_from_camera
    # A given frame draws numbers of its own: what is drawn later does not depend on it.
    floor = fit_shown_floor(image, seen, max_tilt, rng if frame is None else np.random.default_rng(0))
    up = floor.normal if floor else room_planes.find_up(seen.points, seen.known, max_tilt)
    if frame is not None:
        check_frame(frame, floor, up)
    else:
        frame = room_planes.make_floor_frame(floor or find_unnamed_floor(image, seen, up, max_tilt))
        if image.annotations.floor is None:
            what = "level surface that most objects stand on" if image.annotations.objects else "lowest level surface"
            print(f"no mask of the floor: taken to be the {what}, {frame[2, 3]:.2f} m below the camera")
    if doubt := doubt_height(float(frame[2, 3])):
        print(doubt)
    return frame


def check_frame(frame: Array, floor: Plane | None, up: Array | None) -> None:
    """Compare a given `floor_from_camera` (4, 4) with the floor that its mask shows; without it, with what is up (3,).

    Raises:
        InputError: they contradict each other.
    """
    if up is None:
        return
    tilt = float(np.degrees(np.arccos(np.clip(frame[2, :3] @ up, -1, 1))))
    height, seen = float(frame[2, 3]), -floor.offset if floor else 0.0
    what = "the floor that the mask shows" if floor else "the level surfaces"
    if tilt > 180 - SAME_DIRECTION:
        fault = f"is upside down: its z points into {what}."
    elif tilt > (SAME_DIRECTION if floor else MOST_LEANING):
        fault = f"is turned by {tilt:.0f} degrees against {what}."
    elif floor and abs(height / seen - 1) > MOST_OFF:
        fault = f"puts the camera {height:.2f} m above the floor, depth of the floor's pixels {seen:.2f} m."
    else:
        return
    mend = "give z up, metres, and the camera's axes x right, y down, z forward; or leave it out: it is fitted"
    raise InputError("camera.json", f"floor_from_camera {fault}", mend, code="E-FLOOR-FRAME")


def fit_shown_floor(image: AnnotatedImage, seen: PointMap, max_tilt: float, rng: np.random.Generator) -> Plane | None:
    """The floor by its mask; None if there is none, or it is above the camera."""
    if image.annotations.floor is None:
        return None
    floor = room_planes.fit_floor(seen.of(image.masks == image.annotations.floor), max_tilt, rng)
    return floor if floor is not None and floor.offset < 0 else None


def find_unnamed_floor(image: AnnotatedImage, seen: PointMap, up: Array | None, max_tilt: float) -> Plane:
    """The floor without a mask of it; `max_tilt` as of `find_floor_frame`.

    Raises:
        InputError: nothing level is seen below the camera.
    """
    named = [item.mask for item in image.annotations.objects]
    clouds = [cloud for value in named if len(cloud := seen.of(image.masks == value))]
    free = seen.known & ~np.isin(image.masks, [*named, *image.annotations.walls])
    floor = None if up is None else find_floor(seen.points, seen.known, free, clouds, up)
    if floor is None:
        check_turned("depth.npz", seen.points, seen.known, max_tilt)
        what, fix = "shows no level surface that could be the floor.", "check depth (metres) and intrinsics"
        raise InputError("depth.npz", what, fix, code="E-FLOOR-MISSING")
    return floor


def find_room_walls(
    image: AnnotatedImage, seen: PointMap, rng: np.random.Generator
) -> tuple[list[Wall], dict[int, Wall]]:
    """The walls, and by the mask values that show them.

    Args:
        seen: what is used of the picture, floor frame.
    """
    planes, shown, camera_height = [], [], float(seen.frame[2, 3])
    others = seen.known & ~np.isin(image.masks, [item.mask for item in image.annotations.objects])
    others &= image.masks != image.annotations.floor
    for value in image.annotations.walls:
        mask = erode(seen.known & (image.masks == value))
        plane = room_planes.fit_wall(seen.of(mask), camera_height, rng)
        if plane is not None:
            planes.append(plane)
            shown.append(value)
            others &= ~(seen.points @ plane.normal - plane.offset < 3 * room_planes.PLANE_THRESHOLD)
    planes += room_planes.find_walls(seen.of(seen.known), others[seen.known], camera_height, rng.spawn(1)[0])
    merged, places = room_planes.merge_walls(planes)
    walls = [
        Wall(id=f"wall_{k}", normal=(float(normal[0]), float(normal[1]), 0.0), offset=float(offset), points=count)
        for k, (normal, offset, count) in enumerate(merged, start=1)
    ]
    return walls, {value: walls[place] for value, place in zip(shown, places, strict=False)}
