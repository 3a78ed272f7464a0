"""Names of what a mask shows: by its shape as points, by its looks to two networks, and by a detector, in one."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import torch
import yaml
from numpy.typing import NDArray
from torch import Tensor, nn

from roomkin.stages.geometry.frames import back_project, transform_points
from roomkin.stages.geometry.masks import GREY, pixel_bounds
from roomkin.stages.perception.classification.clip import EMBEDDED, embed, load_tower, show
from roomkin.stages.perception.classification.efficientnet import INSTALL, SIZE, classifier, to_input
from roomkin.stages.perception.classification.names import LikelyName, Names
from roomkin.stages.perception.classification.network import ShapeNetwork, load_weights

Array = NDArray[np.float64]
MARGIN = 1.15  # times the longer side of a mask's box that the classifier sees; chosen
WITHOUT_CLASSES = f"names are right less often without ImageNet's classifier: {INSTALL}"
WITHOUT_LOOKS = "names are right less often without CLIP: make weights"
Mask = NDArray[np.bool_]
POINTS, AROUND = 256, 128  # points of the mask and of what is around it
REACH = 0.5  # metres around the mask's box from which those are; chosen
TRIM = 0.02  # share of points left out at either end of a box; chosen
MIN_POINTS = 20  # points that show a shape; chosen
FAR = -5.0  # metres, where the points around lie of a mask that has nothing around it
# Added to what each says: classes of ImageNet are ours but nearly; chosen.
FLOORS = np.array([[1e-4], [0.02], [1e-3], [1e-3]])
FIX_HEAD = "python -m benchmarks.name_training looks writes it"
FIX = "python -m benchmarks.name_training learn writes it"
HERE = Path(__file__).parent
NETWORK, CLASSES, COCO = HERE / "shape.safetensors", HERE / "classes.yaml", HERE / "coco.yaml"
HEAD = HERE / "looks.safetensors"


class ShapeInput(NamedTuple):
    """The network's input for a mask.

    Attributes:
        points: (POINTS, 3) float32 metres: away from, and across what the camera looks at; the origin is below the
            middle of their box; z is the height above what things stand on.
        around: (AROUND, 3) likewise, of what is around the mask.
        numbers: (NUMBERS,) metres from the camera to the middle, level, and the camera's height; whether the picture's
            border cuts the mask above, below, left, right; shares of the mask that has depth, and of its box that it
            fills.
    """

    points: NDArray[np.float32]
    around: NDArray[np.float32]
    numbers: NDArray[np.float32]


def measure_shape(room: Array, known: Mask, mask: Mask, camera_height: float) -> ShapeInput | None:
    """The shape of what a mask shows; None: too few points.

    Args:
        room: (H, W, 3) points, metres, z up from what things stand on, the camera at (0, 0, `camera_height`).
        known: (H, W) where there is depth.
        mask: (H, W).
    """
    rng, points = np.random.default_rng(0), room[mask & known]
    if len(points) < MIN_POINTS:
        return None
    low, high = np.quantile(points, [TRIM, 1 - TRIM], axis=0)
    middle = (low + high) / 2
    far = float(np.linalg.norm(middle[:2]))
    away = middle[:2] / max(far, 1e-6)
    turn = np.array([[*away, 0], [-away[1], away[0], 0], [0, 0, 1]])
    every = (slice(None, None, 2),) * 2  # second pixel: enough of what is around
    beside = room[every][(known & ~mask)[every]]
    near = beside[(np.abs(beside - middle) < (high - low) / 2 + REACH).all(axis=1)]

    def sample(some: Array, count: int) -> NDArray[np.float32]:
        chosen = some[rng.choice(len(some), count, replace=len(some) < count)]
        return np.asarray((chosen - [*middle[:2], 0]) @ turn.T, np.float32)

    rows, columns = np.nonzero(mask)
    height, width = mask.shape
    box = (np.ptp(rows) + 1) * (np.ptp(columns) + 1)
    cut = (rows.min() <= 1, rows.max() >= height - 2, columns.min() <= 1, columns.max() >= width - 2)
    return ShapeInput(
        sample(points, POINTS),
        sample(near, AROUND) if len(near) >= MIN_POINTS else np.full((AROUND, 3), FAR, np.float32),
        np.array([far, camera_height, *cut, len(points) / mask.sum(), mask.sum() / box], np.float32),
    )


class Observed(NamedTuple):
    """The observations of a mask.

    Attributes:
        shape: None: there is too little depth.
        classes: (1000,) scores of ImageNet's classes, logits; None: the classifier is not installed.
        looks: (512,) CLIP's embedding, a unit vector; None: its weights are not here.
    """

    shape: ShapeInput | None = None
    classes: Array | None = None
    looks: Array | None = None


def list_silent() -> list[str]:
    """Lines about networks whose weights are not here, and which say nothing."""
    silent = {WITHOUT_CLASSES: classifier() is None, WITHOUT_LOOKS: load_tower() is None}
    return [line for line, lacks in silent.items() if lacks]


def observe(rgb: NDArray[np.uint8], depth: Array, mask: NDArray[np.bool_], intrinsics: Array, frame: Array) -> Observed:
    """What a picture shows of a mask with at least one pixel.

    Args:
        rgb: (H, W, 3).
        depth: (H, W) metres, 0: unknown.
        mask: (H, W).
        intrinsics: (3, 3) pixels.
        frame: floor_from_camera (4, 4), z = 0: what things stand on.
    """
    room = transform_points(frame, back_project(depth, intrinsics))
    return observe_looks(rgb, mask)._replace(shape=measure_shape(room, depth > 0, mask, float(frame[2, 3])))


def observe_looks(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Observed:
    """What a picture (H, W, 3) shows of a mask (H, W) with at least one pixel, without depth."""
    tower = load_tower()
    looks = None if tower is None else np.asarray(embed(tower, show(rgb, mask)[None])[0], float)
    return Observed(None, classify(rgb, mask), looks)


def classify(rgb: NDArray[np.uint8], mask: NDArray[np.bool_]) -> Array | None:
    """Scores (1000,) of ImageNet's classes for a mask, in a grey square a little larger than it."""
    network = classifier()
    if network is None:
        return None
    x0, y0, x1, y1 = pixel_bounds(mask)
    shown, (height, width) = mask[y0:y1, x0:x1], (y1 - y0, x1 - x0)
    side = round(MARGIN * max(height, width))
    square = np.full((side, side, 3), GREY, np.uint8)
    top, left = (side - height) // 2, (side - width) // 2
    square[top : top + height, left : left + width] = np.where(shown[..., None], rgb[y0:y1, x0:x1], GREY)
    method = cv2.INTER_AREA if side > SIZE else cv2.INTER_LINEAR
    picture = cv2.resize(square, (SIZE, SIZE), interpolation=method)
    with torch.inference_mode():
        return np.asarray(network(to_input(np.asarray(picture[None], np.uint8)))[0].double().numpy())


class Exponents(NamedTuple):
    """Exponents of the probabilities by shape, ImageNet's classifier, a detector and CLIP; `other`: added to the
    logarithm of that of none of the categories. By `benchmarks/names.py --fit` on `work`, rounded towards what outlines
    of real photographs ask for: renderings trust ImageNet too much, and the detector too little.
    """

    shape: float = 0.82
    classes: float = 0.5
    coco: float = 0.8
    looks: float = 0.8
    other: float = 5.3


def read_names(path: Path) -> list[str]:
    """The names that the outputs of a network of ours are."""
    from safetensors import safe_open

    with safe_open(path, "pt") as file:
        return list(file.metadata()["names"].split())


@cache
def read_network(path: Path = NETWORK) -> tuple[ShapeNetwork, list[str]]:
    """The network of a file, and the names that its outputs are; the last is none of the categories."""
    names = read_names(path)
    return load_weights(ShapeNetwork(len(names)), path, FIX), names


@cache
def read_head(path: Path = HEAD) -> tuple[nn.Linear, list[str]]:
    """The layer from CLIP's embeddings to names, and these; the last is none of the categories."""
    names = read_names(path)
    return load_weights(nn.Linear(EMBEDDED, len(names)), path, FIX_HEAD), names


@cache
def read_classes() -> dict[str, list[int]]:
    """The classes of ImageNet that are a category."""
    return {name: list(classes) for name, classes in yaml.safe_load(CLASSES.read_text(encoding="utf-8")).items()}


@cache
def read_coco() -> dict[str, dict[str, float]]:
    """For each of COCO's indoor classes how often what is called so is of which category."""
    return dict(yaml.safe_load(COCO.read_text(encoding="utf-8")))


def share_network(trained: tuple[nn.Module, list[str]], names: Sequence[str], *given: Tensor) -> Array:
    """The probability (C,) of each name by a network of ours, of what it is given."""
    network, known = trained
    with torch.inference_mode():
        share = network(*given).double().flatten().softmax(dim=0).numpy()
    return np.array([share[known.index(name)] for name in names])


def share_classes(scores: Array, names: Sequence[str]) -> Array:
    """The share (C,) of each name among those classes of ImageNet (1000 scores) that are ours at all."""
    classes = read_classes()
    ours = sorted({one for name in names for one in classes.get(name, [])})
    share = np.zeros(len(scores))
    share[ours] = np.exp(scores[ours] - scores[ours].max())
    share /= share.sum()
    return np.array([share[classes.get(name, [])].sum() for name in names])


def share_coco(said: Mapping[str, float], names: Sequence[str]) -> Array:
    """The probability (C,) of each name by a detector's scores of COCO's classes; what they leave is of all alike. A
    detector that was asked for the library's categories answers with their names."""
    share = np.zeros(len(names))
    for word, score in said.items():
        meant = read_coco().get(word, {word.replace(" ", "_"): 1.0})
        parts = np.array([meant.get(name, 0.0) for name in names])
        share += score * parts / max(parts.sum(), 1e-9)
    return (share + max(0.0, 1 - share.sum()) / len(names)) / max(1.0, share.sum())


def gather(observed: Observed, coco: Mapping[str, float] | None, names: Sequence[str]) -> Array:
    """Probabilities (4, C) of names by shape, ImageNet's classifier, a detector, CLIP; all alike by who is silent."""
    said = np.full((4, len(names)), 1 / len(names))
    if observed.shape is not None:
        said[0] = share_network(read_network(), names, *(torch.from_numpy(part)[None] for part in observed.shape))
    if observed.classes is not None:
        said[1] = share_classes(observed.classes, names)
    if coco:
        said[2] = share_coco(coco, names)
    if observed.looks is not None:
        said[3] = share_network(read_head(), names, torch.from_numpy(observed.looks).float())
    return said


def combine(said: Array, weights: Exponents) -> Array:
    """The probabilities (..., C) of the names by what is said (..., 4, C); the last name is none of the categories."""
    total = np.log(said + FLOORS) * [[weight] for weight in weights[:4]]
    summed = total.sum(axis=-2)
    summed[..., -1] += weights.other
    share = np.exp(summed - summed.max(axis=-1, keepdims=True))
    return np.asarray(share / share.sum(axis=-1, keepdims=True))


def propose_names(observed: Observed, coco: Mapping[str, float] | None = None) -> Names:
    """The categories, surest first, and how likely it is none of them; every name is as likely before.

    Args:
        observed: of a mask, see `observe`.
        coco: what a detector takes it for: scores, 0 to 1, of COCO's classes by their names; None: nothing.
    """
    _, names = read_network()
    share = combine(gather(observed, coco, names), Exponents())
    order = np.argsort(-share[:-1], kind="stable")
    return Names([LikelyName(names[one].replace("_", " "), float(share[one])) for one in order], float(share[-1]))
