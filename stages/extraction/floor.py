"""The floor frame of a picture: given and compared with the floor that is seen, or fitted; and depth that is noise."""

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.extraction.camera_height import doubt_height
from stages.extraction.observation import AnnotatedImage
from stages.geometry.frames import Array
from stages.geometry.gravity import cell_normals, estimate_up
from stages.geometry.levels import find_floor
from stages.geometry.masks import Mask
from stages.geometry.planes import Plane
from stages.geometry.room_planes import SAME_DIRECTION, fit_floor, make_floor_frame

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
        raise InputError(
            "depth.npz", what, "give depth of this picture, unpacked as its camera says", code="E-DEPTH-NOISE"
        )


def find_floor_frame(
    image: AnnotatedImage, points: Array, usable: Mask, max_tilt: float, rng: np.random.Generator
) -> Array:
    """`floor_from_camera` (4, 4): as given, else from the floor's mask, else from the level planes.

    It prints where the floor was found without a mask, and a doubtful height of the camera.

    Args:
        points: (H, W, 3) of the pixels, camera frame; only those `usable` (H, W) count.
        max_tilt: largest angle between image-up and the floor's normal, degrees.

    Raises:
        InputError: no floor is seen, or it is not where the given frame says.
    """
    frame = image.floor_from_camera
    if frame is not None:
        check_frame(frame, image, points, usable, max_tilt)
    else:
        shown = fit_shown_floor(image, points, usable, max_tilt, rng)
        frame = make_floor_frame(shown or find_unnamed_floor(image, points, usable, max_tilt))
        if image.annotations.floor is None:
            what = "level surface that most objects stand on" if image.annotations.objects else "lowest level surface"
            print(f"no mask of the floor: taken to be the {what}, {frame[2, 3]:.2f} m below the camera")
    if doubt := doubt_height(float(frame[2, 3])):
        print(doubt)
    return frame


def check_frame(frame: Array, image: AnnotatedImage, points: Array, usable: Mask, max_tilt: float) -> None:
    """Compare a given `floor_from_camera` (4, 4) with the floor's pixels; without them, its up with all surfaces.

    Raises:
        InputError: they contradict each other.
    """
    rng = np.random.default_rng(0)  # of its own: what is drawn later does not depend on it
    floor = fit_shown_floor(image, points, usable, max_tilt, rng)
    up = floor.normal if floor else estimate_up(cell_normals(points, usable)[1], max_tilt)
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


def fit_shown_floor(
    image: AnnotatedImage, points: Array, usable: Mask, max_tilt: float, rng: np.random.Generator
) -> Plane | None:
    """The floor by its mask; None if there is none, or it is above the camera."""
    if image.annotations.floor is None:
        return None
    floor = fit_floor(points[usable & (image.masks == image.annotations.floor)], max_tilt, rng)
    return floor if floor is not None and floor.offset < 0 else None


def find_unnamed_floor(image: AnnotatedImage, points: Array, usable: Mask, max_tilt: float) -> Plane:
    """The floor without a mask of it.

    Raises:
        InputError: nothing level is seen below the camera.
    """
    named = [item.mask for item in image.annotations.objects]
    clouds = [cloud for value in named if len(cloud := points[usable & (image.masks == value)])]
    free = usable & ~np.isin(image.masks, [*named, *image.annotations.walls])
    floor = find_floor(points, usable, free, clouds, max_tilt)
    if floor is None:
        raise InputError(
            "depth.npz",
            "shows no level surface that could be the floor.",
            "check depth (metres) and intrinsics",
            code="E-FLOOR-MISSING",
        )
    return floor
