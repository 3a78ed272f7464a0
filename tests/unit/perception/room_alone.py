"""A room of boxes, drawn without depth: its lines, and the outlines of its things as boxes show them."""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import rotation_of
from roomkin.stages.perception.camera.metrology import PinholeView
from roomkin.stages.perception.camera.perspective import Guide, Perspective, fit_view
from roomkin.stages.perception.layout.fit import CameraPrior
from roomkin.stages.perception.layout.room import Arrangement, FittedRoom, arrange, build_room
from roomkin.stages.perception.segmentation.proposal import find_border

WIDTH, HEIGHT = 640, 480
TRUE = PinholeView(WIDTH, HEIGHT, 520.0, rotation_of(0.25, -0.28, 0.0), 1.45)
LABELS = {1: "fridge", 2: "sofa", 3: "coffee table", 4: "mug", 5: "picture", 6: "nightstand"}
BOXES = {  # in the room: x to the right along the far wall, y away from us, which stands at y = 4.4
    1: UprightBox([-2.1, 4.05, 0.9], [0.7, 0.7, 1.8], 0.0),
    2: UprightBox([0.4, 3.95, 0.42], [1.8, 0.9, 0.84], 0.0),
    3: UprightBox([0.0, 2.6, 0.22], [1.0, 0.6, 0.44], 0.0),
    4: UprightBox([0.1, 2.6, 0.49], [0.09, 0.09, 0.1], 0.0),
    5: UprightBox([0.3, 4.38, 1.6], [0.6, 0.04, 0.45], 0.0),
    6: UprightBox([-1.2, 4.15, 0.26], [0.45, 0.42, 0.52], 0.0),
}
LINES = {
    "x": [((-3, 4.4, 0), (2, 4.4, 0)), ((-3, 4.4, 2.5), (2, 4.4, 2.5)), ((-0.5, 2.3, 0.44), (0.5, 2.3, 0.44))],
    "y": [((-2.45, 3.7, 1.8), (-2.45, 4.4, 1.8)), ((0.5, 2.3, 0.44), (0.5, 2.9, 0.44)), ((1.3, 3.5, 0), (1.3, 4.4, 0))],
    "z": [
        ((-1.75, 3.7, 0), (-1.75, 3.7, 1.8)),
        ((-2.45, 3.7, 0), (-2.45, 3.7, 1.8)),
        ((1.3, 3.5, 0), (1.3, 3.5, 0.84)),
    ],
}

_arranged: dict[tuple[object, ...], Arrangement] = {}


def arrange_once(
    rgb: NDArray[np.uint8], camera: CameraPrior, masks: NDArray[np.integer], labels: Mapping[int, str]
) -> Arrangement:
    """`arrange`, which takes seconds, once for all tests of the same room."""
    asked = rgb.tobytes(), repr(camera), masks.tobytes(), tuple(labels.items())
    if asked not in _arranged:
        _arranged[asked] = arrange(camera, masks, labels, ~find_border(rgb))
    return _arranged[asked]


def build_once(
    rgb: NDArray[np.uint8], camera: CameraPrior, masks: NDArray[np.integer], labels: Mapping[int, str]
) -> FittedRoom:
    """The room of what is given."""
    return build_room(rgb, arrange_once(rgb, camera, masks, labels), masks)


def see_lines(likely_focal: float = 512.0, spread: float = 0.3, view: PinholeView = TRUE) -> CameraPrior:
    """The camera by the room's lines, as a view shows them."""
    guides = []
    for axis, lines in LINES.items():
        for line in lines:
            a, b = (tuple(pixel) for pixel in view.project(line).tolist())
            guides.append(Guide(axis=axis, a=a, b=b))  # type: ignore[arg-type]
    given = Perspective(guides=guides, likely_focal=likely_focal, spread=spread)
    return CameraPrior(given, fit_view(given, WIDTH, HEIGHT))


def outline_box(box: UprightBox) -> NDArray[np.bool_]:
    """The pixels (H, W) that a box would cover alone."""
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    hull = cv2.convexHull(TRUE.project(corners(box)).astype(np.float32))
    cv2.fillConvexPoly(mask, np.rint(hull).astype(np.int32), 1)
    return mask > 0


def outline_room(values: tuple[int, ...] = tuple(BOXES)) -> NDArray[np.uint16]:
    """Masks (H, W): of two boxes the nearer is seen, of what carries another that other."""
    masks = np.zeros((HEIGHT, WIDTH), np.uint16)
    for value in sorted(values, key=lambda value: -float(BOXES[value].center[1]) - 10 * (value == 5) + (value == 4)):
        masks[outline_box(BOXES[value])] = value
    return masks


def show_room() -> NDArray[np.uint8]:
    """A picture (H, W, 3) of nothing: masks say where things are."""
    return np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
