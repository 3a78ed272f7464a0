"""The shape of what a mask shows and of what is around it, as points: the input of the network."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
POINTS, AROUND, NUMBERS = 256, 128, 8  # points of the mask and of what is around it; what else is told
REACH = 0.5  # metres around the mask's box from which those are; chosen
TRIM = 0.02  # share of points left out at either end of a box; chosen
MIN_POINTS = 20  # points that show a shape; chosen
FAR = -5.0  # metres, where the points around lie of a mask that has nothing around it


class Shape(NamedTuple):
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


def measure_shape(room: Array, known: Mask, mask: Mask, camera_height: float) -> Shape | None:
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
    return Shape(
        sample(points, POINTS),
        sample(near, AROUND) if len(near) >= MIN_POINTS else np.full((AROUND, 3), FAR, np.float32),
        np.array([far, camera_height, *cut, len(points) / mask.sum(), mask.sum() / box], np.float32),
    )
