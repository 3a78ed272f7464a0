"""Extents of a model: fitted to all that is known of its object, or measured as in the paper (A.7)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.category import Category
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.generation.fitting import POINTS, Observation, Prior, fit_box
from roomkin.stages.generation.inputs import MatchedObject
from roomkin.stages.generation.mounting import extend_to_wall, move_to_wall
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.solid import read_solid
from roomkin.stages.geometry.boxes import UprightBox, is_behind
from roomkin.stages.geometry.frames import yaw_matrix


def size(
    placed: Placed,
    yaw: float,
    one: MatchedObject,
    scene: Objects,
    category: Category | None,
    reached: Sequence[Wall],
    options: GenerationConfig,
) -> Placed:
    """A model at a yaw with the extents of its object.

    Args:
        category: of the model.
        reached: walls that it is extended to.
    """
    measured = measure_box(placed.box, one.cloud.astype(float), yaw, options.trim)
    placed = placed.change_box("measured along the model's axes", measured)
    if options.sizes == "measured":
        for wall in reached:
            placed = placed.change_box(f"rear to {wall.id}", extend_to_wall(placed.box, wall))
        return placed
    known = Prior(
        native=np.array(placed.asset.size),
        is_round=placed.asset.symmetry == "full",
        usual=category.measure_spread() if category else None,
        bottom=None if placed.wall_mounted else placed.bottom,
        walls=[wall for wall in scene.walls if not is_behind(placed.box, wall.normal, wall.offset)],
        touched=reached,
    )
    seen = Observation(
        np.array(scene.floor_from_camera),
        np.array(scene.intrinsics),
        one.outline,
        one.cloud[:: max(1, len(one.cloud) // POINTS)].astype(float),
        scene.depth_error,
    )
    fit = fit_box(read_solid(placed.folder), placed.box, seen, known)
    placed = placed.change_box("fitted to the picture", fit.box)
    placed = replace(placed, spread=tuple(fit.spread.tolist()), place_spread=float(np.linalg.norm(fit.shift)))
    for wall in reached:
        placed = placed.change_box(f"to {wall.id}", move_to_wall(placed.box, wall))
    return placed


def measure_box(box: UprightBox, points: NDArray[np.float64], yaw: float, trim: float) -> UprightBox:
    """The box of points (N, 3) along axes turned by `yaw`, its heights those of `box`.

    Args:
        trim: share of the points left out at each end.
    """
    turn = yaw_matrix(yaw)[:2, :2]
    low, high = np.quantile(points[:, :2] @ turn, [trim, 1 - trim], axis=0)
    return UprightBox([*turn @ (low + high) / 2, box.center[2]], [*high - low, box.size[2]], yaw)
