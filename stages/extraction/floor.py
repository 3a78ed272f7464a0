"""The floor frame of a picture: given and compared with the floor that is seen, or fitted; and depth that is noise."""

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts import InputError
from stages.contracts.doubts import doubt_height
from stages.extraction import room
from stages.extraction.observation import AnnotatedImage
from stages.geometry.planes import Plane

ROUGH = 0.05  # share of the distance by which neighbouring pixels differ in the middle: no surface is so rough
TILTED, OFF = 10.0, 0.2  # degrees, and share of the camera's height, by which a given frame is not that of the picture
UPRIGHT = 45.0  # degrees, likewise, if nobody says what is the floor


def check_smooth(depth: NDArray[np.floating]) -> None:
    """Refuse depth (H, W) whose neighbouring pixels have nothing to do with each other.

    Raises:
        InputError: it is noise.
    """
    known = (depth[:, 1:] > 0) & (depth[:, :-1] > 0)
    steps = np.abs(np.diff(depth, axis=1))[known] / depth[:, 1:][known]
    if len(steps) and (rough := float(np.median(steps))) > ROUGH:
        what = f"is noise: pixels side by side differ by {100 * rough:.0f} % in the middle."
        raise InputError("depth.npz", what, "give depth of this picture, unpacked as its camera says", "E-DEPTH-NOISE")


def frame_of(
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """`floor_from_camera` (4, 4) as given, from the floor mask, or from the level planes if there is no mask or it is
    no use. What is odd about it is printed.

    Raises:
        InputError: no floor is seen, or it is not where the given frame says.
    """
    given = image.floor_from_camera
    if given is not None:
        check_frame(given, points, image, usable, options)
        frame = given
    else:
        frame = room.floor_frame(
            _painted(points, image, usable, options, rng) or _found(points, image, usable, options, rng)
        )
        if image.annotations.floor is None:
            what = (
                "the level plane that most objects stand on" if image.annotations.objects else "the lowest level plane"
            )
            print(f"no mask of the floor: taken to be {what}, {frame[2, 3]:.2f} m below the camera")
    if doubt := doubt_height(float(frame[2, 3])):
        print(doubt)
    return frame


def check_frame(
    frame: NDArray[np.float64],
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    options: ExtractionConfig,
) -> None:
    """Compare a given `floor_from_camera` (4, 4) with the floor's pixels; without them, its up with the level planes.

    Raises:
        InputError: they do not go together.
    """
    rng = np.random.default_rng(0)  # of its own: what is drawn later does not depend on it
    floor = _painted(points, image, usable, options, rng)
    plane = floor or max(
        room.level_planes(points[usable], options, rng), key=lambda one: one.inliers.sum(), default=None
    )
    if plane is None:
        return
    tilt = float(np.degrees(np.arccos(np.clip(frame[2, :3] @ plane.normal, -1, 1))))
    height, seen = float(frame[2, 3]), -plane.offset
    what = "the floor that the mask shows" if floor else "the largest level plane"
    if tilt > 180 - TILTED:
        fault = f"is upside down: its z points into {what}."
    elif tilt > (TILTED if floor else UPRIGHT):
        fault = f"is turned by {tilt:.0f} degrees against {what}."
    elif floor and abs(height / seen - 1) > OFF:
        fault = f"puts the camera {height:.2f} m above the floor, depth of the floor's pixels {seen:.2f} m."
    else:
        return
    mend = "give z up, metres, and the camera's axes x right, y down, z forward; or leave it out: it is fitted"
    raise InputError("camera.json", f"floor_from_camera {fault}", mend, code="E-FLOOR-FRAME")


def _painted(
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> Plane | None:
    """The floor by its mask; None if there is none, or it is above the camera."""
    if image.annotations.floor is None:
        return None
    floor = room.fit_floor(points[usable & (image.masks == image.annotations.floor)], options, rng)
    return floor if floor is not None and floor.offset < 0 else None


def _found(
    points: NDArray[np.float64],
    image: AnnotatedImage,
    usable: NDArray[np.bool_],
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> Plane:
    """The floor without a mask of it."""
    named = [item.mask for item in image.annotations.objects]
    clouds = [cloud for value in named if len(cloud := points[usable & (image.masks == value)])]
    rest = points[usable & ~np.isin(image.masks, [*named, *image.annotations.walls])]
    floor = room.find_floor(rest, clouds, options, rng) or room.find_floor(points[usable], clouds, options, rng)
    if floor is None:
        raise InputError(
            "depth.npz",
            "shows no level plane that could be the floor.",
            "check depth (metres) and intrinsics",
            code="E-FLOOR-MISSING",
        )
    return floor
