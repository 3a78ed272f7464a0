"""The floor frame of a picture: given and compared with the floor that is seen, or fitted; and depth that is noise."""

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts import InputError
from stages.contracts.doubts import height_doubt
from stages.extraction import room
from stages.extraction.observation import AnnotatedImage
from stages.geometry.planes import Plane

ROUGH = 0.05  # share of the distance by which neighbouring pixels differ in the middle: no surface is so rough
TILTED, OFF = 10.0, 0.2  # degrees, and share of the camera's height, by which a given frame is not that of the picture


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
    floor = None
    if image.annotations.floor is not None:
        floor = room.fit_floor(points[usable & (image.masks == image.annotations.floor)], options, rng)
    if floor is not None and floor.offset >= 0:
        floor = None  # the camera is below it
    if image.floor_from_camera is not None:
        frame = image.floor_from_camera
        if floor is not None:
            check_frame(frame, floor)
    else:
        frame = room.floor_frame(floor or _found(points, image, usable, options, rng))
    if doubt := height_doubt(float(frame[2, 3])):
        print(doubt)
    return frame


def check_frame(frame: NDArray[np.float64], floor: Plane) -> None:
    """Compare a given `floor_from_camera` (4, 4) with the plane of the floor's pixels, camera frame.

    Raises:
        InputError: they are not the same floor.
    """
    tilt = float(np.degrees(np.arccos(np.clip(frame[2, :3] @ floor.normal, -1, 1))))
    given, seen = float(frame[2, 3]), -floor.offset
    if tilt > 180 - TILTED:
        what = "is upside down: its z points into the floor that the mask shows."
    elif tilt > TILTED:
        what = f"is turned by {tilt:.0f} degrees against the floor that the mask shows."
    elif abs(given / seen - 1) > OFF:
        what = f"puts the camera {given:.2f} m above the floor, depth of the floor's pixels {seen:.2f} m."
    else:
        return
    mend = "give z up, metres, and the camera's axes x right, y down, z forward; or leave it out: it is fitted"
    raise InputError("camera.json", f"floor_from_camera {what}", mend, code="E-FLOOR-FRAME")


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
    if image.annotations.floor is None:
        what = "the level plane that most objects stand on" if image.annotations.objects else "the lowest level plane"
        print(f"no mask of the floor: taken to be {what}, {-floor.offset:.2f} m below the camera")
    return floor
