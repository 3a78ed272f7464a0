"""Propose names for the thing that a mask shows: what shape, ImageNet's classifier and a detector say, in one."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
import yaml
from numpy.typing import NDArray

from plugins.names.network import ShapeNetwork
from plugins.names.observed import Observed
from plugins.names.shape import Shape
from plugins.pretrained.weights import load_weights

Array = NDArray[np.float64]
HERE = Path(__file__).parent
NETWORK, CLASSES, COCO = HERE / "shape.safetensors", HERE / "classes.yaml", HERE / "coco.yaml"
FLOORS = np.array([[1e-4], [0.02], [1e-3]])  # added to what each says: classes of ImageNet are ours but nearly; chosen
FIX = "python -m plugins.names learn writes it"


class Weights(NamedTuple):
    """Exponents of the probabilities by shape, ImageNet's classifier and a detector; `other`: added to the logarithm of
    that of none of the categories. By `benchmarks/names.py --fit` on `work`.
    """

    shape: float = 0.83
    classes: float = 0.99
    coco: float = 0.83
    other: float = 6.08


class Proposal(NamedTuple):
    """A category of the library, in words, and how sure it is, 0 to 1."""

    name: str
    probability: float


class Names(NamedTuple):
    """Categories, surest first, and the probability that it is none of them: together 1."""

    proposals: list[Proposal]
    other: float


@cache
def read_network(path: Path = NETWORK) -> tuple[ShapeNetwork, list[str]]:
    """The network of a file, and the names that its outputs are; the last is none of the categories."""
    from safetensors import safe_open

    with safe_open(path, "pt") as file:
        names = file.metadata()["names"].split()
    return load_weights(ShapeNetwork(len(names)), path, FIX), names


@cache
def read_classes() -> dict[str, list[int]]:
    """The classes of ImageNet that are a category."""
    return {name: list(classes) for name, classes in yaml.safe_load(CLASSES.read_text(encoding="utf-8")).items()}


@cache
def read_coco() -> dict[str, dict[str, float]]:
    """For each of COCO's indoor classes how often what is called so is of which category."""
    found: dict[str, dict[str, float]] = yaml.safe_load(COCO.read_text(encoding="utf-8"))
    return found


def share_shape(shape: Shape, names: Sequence[str]) -> Array:
    """The probability (C,) of each name by its shape."""
    network, known = read_network()
    with torch.inference_mode():
        share = network(*(torch.from_numpy(part)[None] for part in shape))[0].double().softmax(dim=0).numpy()
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
    """The probability (C,) of each name by a detector's scores of COCO's classes; what they leave is of all alike."""
    share = np.zeros(len(names))
    for word, score in said.items():
        parts = np.array([read_coco().get(word, {}).get(name, 0.0) for name in names])
        share += score * parts / max(parts.sum(), 1e-9)
    return (share + max(0.0, 1 - share.sum()) / len(names)) / max(1.0, share.sum())


def gather(observed: Observed, coco: Mapping[str, float] | None, names: Sequence[str]) -> Array:
    """Probabilities (3, C) of the names by shape, ImageNet's classifier and a detector; all alike by who is silent."""
    said = np.full((3, len(names)), 1 / len(names))
    if observed.shape is not None:
        said[0] = share_shape(observed.shape, names)
    if observed.classes is not None:
        said[1] = share_classes(observed.classes, names)
    if coco:
        said[2] = share_coco(coco, names)
    return said


def combine(said: Array, weights: Weights) -> Array:
    """The probabilities (..., C) of the names by what is said (..., 3, C); the last name is none of the categories."""
    total = np.log(said + FLOORS) * [[weight] for weight in weights[:3]]
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
    share = combine(gather(observed, coco, names), Weights())
    order = np.argsort(-share[:-1], kind="stable")
    return Names([Proposal(names[one].replace("_", " "), float(share[one])) for one in order], float(share[-1]))
