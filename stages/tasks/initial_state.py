"""The random initial state of an episode, drawn from its seed alone (paper A.5)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import make_transform, yaw_matrix

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InitialState:
    """The variation between episodes. Offsets are uniform in the ranges of the `task` section; metres, radians."""

    variant: int  # which of the scale variants
    base_offset: Array  # (3,)
    base_yaw: float
    object_offset: Array  # (2,)
    object_yaw: float
    joints: Array  # (7,) added to the rest configuration


def sample_initial_state(seed: int, options: TaskConfig) -> InitialState:
    """The initial state of episode `seed`; the same seed gives the same state for every asset and policy."""
    rng = np.random.default_rng(seed)
    base_range = np.array([options.base_xy, options.base_xy, options.base_z])
    return InitialState(
        variant=int(rng.integers(options.scale_variants)),
        base_offset=rng.uniform(-1, 1, 3) * base_range,
        base_yaw=float(rng.uniform(-1, 1) * options.base_yaw),
        object_offset=rng.uniform(-1, 1, 2) * options.object_xy,
        object_yaw=float(rng.uniform(-1, 1) * options.object_yaw),
        joints=rng.normal(0, 1, 7) * options.qpos_noise,
    )


def sample_scale(seed: int, options: TaskConfig, scale_range: tuple[float, float] | None) -> Array:
    """(3,) scale factors of the asset in episode `seed`; None: its nominal size."""
    if scale_range is None:
        return np.ones(3)
    return variant_scale(sample_initial_state(seed, options).variant, scale_range)


def variant_scale(variant: int, scale_range: tuple[float, float]) -> Array:
    """(3,) scale factors of a variant. They are few, so that each rescaled asset is built once and cached."""
    scale: Array = np.random.default_rng((variant, 31)).uniform(*scale_range, 3).round(3)
    return scale


def base_pose(handle: Array, side: float, setup: InitialState, options: TaskConfig, flap: bool = False) -> Array:
    """(4, 4) pose of the robot base in front of the handle's (3,) nominal place, facing it.

    `side` is +1 or -1 along y: away from the hinge of a door; 0 for a drawer. Before a `flap` the robot stands beside
    the handle, which comes down where it would else stand.
    """
    height = options.handle_height if side else options.drawer_height
    nominal = np.array([options.base_distance, side * options.base_side, -height])
    if flap:
        nominal = np.array([options.flap_base[0], options.flap_base[1], -options.flap_base[2]])
    return make_transform(yaw_matrix(np.pi + setup.base_yaw), handle + nominal + setup.base_offset)


def nominal_root(asset: Asset, scale: Array) -> Array:
    """(3,) where the root of an asset at a scale (3,) nominally is: the box's center above the origin, it on z = 0."""
    box = np.array([asset.box_min, asset.box_max]) * scale
    return np.array([*-box[:, :2].mean(axis=0), -box[0, 2]])


def object_motion(setup: InitialState) -> Array:
    """(4, 4) small turn about z and shift of the object away from its nominal pose."""
    return make_transform(yaw_matrix(setup.object_yaw), [*setup.object_offset, 0.0])
