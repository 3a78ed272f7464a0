"""film.png: a strip of pictures per episode, above what the policy saw, from the front and from the side."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.contracts import atomic

Image = NDArray[np.uint8]
T = TypeVar("T")

FRAMES = 8
SIZE = 256
SCENE, FINGER = (40, 40, 40), (220, 30, 30)


def pick(frames: Sequence[T], count: int = FRAMES) -> list[T]:
    """`count` frames evenly over an episode, the first and the last included."""
    return [frames[i] for i in np.linspace(0, len(frames) - 1, count).round().astype(int)]


def draw_cloud(cloud: NDArray[np.floating]) -> Image:
    """A cloud (P, 4) in the base frame as (SIZE / 2, SIZE, 3): from the front (y, z) and from the side (x, z)."""
    half = SIZE // 2
    image = np.full((half, SIZE, 3), 255, np.uint8)
    scale = half / 1.2  # pixels per metre
    for left, across in ((0, half / 2 - cloud[:, 1] * scale), (half, cloud[:, 0] * scale)):
        u = np.round(across).astype(int)
        v = np.round(half * 0.75 - (cloud[:, 2] - 0.2) * scale).astype(int)
        seen = (u >= 0) & (u < half) & (v >= 0) & (v < half)
        image[v[seen], left + u[seen]] = np.where(cloud[seen, 3:] > 0.5, FINGER, SCENE)
    return image


def strip(pictures: Sequence[Image], clouds: Sequence[NDArray[np.floating]]) -> Image:
    """One episode: pictures in a row, the clouds below them."""
    columns = [
        np.concatenate([cv2.resize(picture, (SIZE, SIZE)), draw_cloud(cloud)])
        for picture, cloud in zip(pick(pictures), pick(clouds), strict=True)
    ]
    return np.concatenate(columns, axis=1)


def write_film(path: Path, strips: Sequence[Image]) -> None:
    """Write the strips below each other."""
    if strips:
        with atomic(path) as temporary:
            cv2.imwrite(str(temporary), np.concatenate(list(strips))[..., ::-1])
