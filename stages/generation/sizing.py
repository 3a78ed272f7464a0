"""Extents of a model: fitted to all that is known of its object, or measured as in the paper (A.7).

Least squares over the center and the logarithms of the extents, every term in its own standard deviations:
* seen: the outline in the picture, and the object's points on the model's surface along their rays (cast at it
  in the unit box), or nearest to it where their rays miss it;
* bounded: an outline that the picture cuts or something nearer hides ends there or later;
* usual: the extents of the category's models, and the model's own proportions;
* the room: the height of what carries it, walls that it touches, walls that nothing reaches behind.
What is seen of another thing than it is (a mask without legs, a chair of other arms) is no Gaussian error, so that
terms count as Cauchy's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from roomkin.stages.articulated.asset_folder import read_asset, urdf_of
from roomkin.stages.articulated.model import frames_of
from roomkin.stages.articulated.urdf_reader import UrdfReader
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.category import CategoryFacts, SizeSpread
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.objects import DepthError, Wall
from roomkin.stages.generation.inputs import MatchedObject
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.turning import extend_to_wall, move_to_wall
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, is_behind
from roomkin.stages.geometry.frames import FloorCamera, transform_points, yaw_matrix
from roomkin.stages.geometry.masks import DIRECTIONS, OUTLINE, Outline
from roomkin.stages.geometry.robust import LARGEST_CHANGE, UNUSUAL, Deviations, find_step
from roomkin.stages.geometry.solids import find_outermost


class VisibleSolid:
    """The visible surface of a model, every joint closed, scaled so that its box is [-0.5, 0.5]^3.

    A box in a scene is an affine map of the unit box, so rays are mapped, never the triangles. visuals: what `scene`
    consists of, one after the other. outermost: vertices (N, 3) that every outline is made of.

    Raises:
        InputError: it is not whole.
    """

    def __init__(self, folder: Path) -> None:
        self.asset = read_asset(folder)
        reader = UrdfReader(urdf_of(folder, self.asset), folder)
        by_link = {name: reader.visuals(name) for name in reader.tree.links}
        if reader.remarks:
            raise InputError(reader.path, reader.remarks[0], code="E-MODEL-BROKEN")
        frames = frames_of(reader.tree.root, reader.joints)
        low, size = np.array(self.asset.box_min), np.maximum(self.asset.size, 1e-6)
        self.visuals = [visual for visuals in by_link.values() for visual in visuals]
        vertices = [
            (transform_points(frames[name], visual.mesh.vertices) - low) / size - 0.5
            for name, visuals in by_link.items()
            for visual in visuals
        ]
        starts = np.cumsum([0, *map(len, vertices[:-1])])
        faces = [visual.mesh.faces + start for visual, start in zip(self.visuals, starts, strict=True)]
        self.outermost = find_outermost(np.concatenate(vertices))
        self.scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.scene.add_triangles(
            o3d.core.Tensor.from_numpy(np.concatenate(vertices).astype(np.float32)),
            o3d.core.Tensor.from_numpy(np.concatenate(faces).astype(np.uint32)),
        )


read_solid = lru_cache(maxsize=64)(VisibleSolid)  # of a folder of the library


POINTS = 400  # of a cloud, for time
ROUNDS, STEPS = 5, 2  # in each of these, points are laid on the model anew; more change nothing
INDEPENDENT_ENDS, INDEPENDENT_POINTS = 8, 20  # of an outline, of points: neighbours err alike; chosen on `work`
SHAPE = 0.02  # of the diagonal: how far the surfaces of cousins are apart; chosen on `work`
PROPORTIONS = 0.3  # deviation of the logarithm of one axis' scale over another's; chosen on `work`
ROUND = 0.03  # the same of the level ones of what is round; chosen
CONTACT_SPREAD = 0.01  # metres: of what stands on something, or touches a wall
TOO_SURE = 2.0  # by which the terms, which err alike, understate the spread; calibrated on `work`
LARGEST_STEP = (0.2, 0.3)  # metres, logarithm: of one step
Array = NDArray[np.float64]


@dataclass(frozen=True)
class SeenObject(FloorCamera):
    """An object as the picture shows it: its outline (None: no mask) and points (N, 3) of it, floor frame."""

    outline: Outline | None
    points: Array
    error: DepthError

    @cached_property
    def rays(self) -> Array:
        """Unit vectors (N, 3) from the camera to the points."""
        rays = self.points - self.eye
        return rays / np.linalg.norm(rays, axis=1, keepdims=True)

    @cached_property
    def noise(self) -> Array:
        """Standard deviation (N,), metres, of the points along their rays."""
        return np.asarray(self.error.predict(transform_points(self.camera_from_floor, self.points)[:, 2]))


@dataclass(frozen=True)
class Prior:
    """Prior knowledge of an object but for its appearance.

    native: extents (3,) of the model in the library. is_round: from above. usual: None where no one says. bottom:
    height of what carries it; None: it hangs. walls: of the room. touched: those at which it ends.
    """

    native: Array
    is_round: bool
    usual: SizeSpread | None
    bottom: float | None
    walls: Sequence[Wall]
    touched: Sequence[Wall]


class FittedBox(NamedTuple):
    """A box, and the standard deviations of its center (3,), metres, and of the logarithms of its extents (3,)."""

    box: UprightBox
    shift: Array
    spread: Array
    cost: float


# What of a surface belongs to each of N points: points and normals (N, 3) in the unit box.
Correspondences = tuple[Array, Array]


def fit_box(solid: VisibleSolid, start: UprightBox, seen: SeenObject, known: Prior) -> FittedBox:
    """The best box of a model with the yaw of `start`, from there or from its own size there."""
    own = UprightBox(start.center, known.native, start.yaw)
    return min((improve_box(solid, box, seen, known) for box in (start, own)), key=lambda fit: fit.cost)


def improve_box(solid: VisibleSolid, start: UprightBox, seen: SeenObject, known: Prior) -> FittedBox:
    """The best box of a model near `start`, whose yaw it keeps: Gauss-Newton with Cauchy's weights."""
    size = np.maximum(start.size, THINNEST)
    change, small = np.zeros(6), 1e-4
    damping = np.repeat([1e-4 / 0.05**2, 1e-4 / 0.1**2], 3)
    bound = np.repeat(LARGEST_STEP, 3)
    curvature, tolerance = np.eye(6), SHAPE * float(np.linalg.norm(size))

    def change_box(change: Array) -> UprightBox:
        return UprightBox(start.center + change[:3], size * np.exp(change[3:]), start.yaw)

    def measure_with(on: Correspondences) -> Callable[[Array], Deviations]:
        return lambda change: compare(change_box(change), solid, on, seen, known, tolerance)

    for _ in range(ROUNDS):
        on = find_correspondences(solid, seen, change_box(change))
        for _ in range(STEPS):
            step, curvature = find_step(measure_with(on), change, small, damping)
            change = change - np.clip(step, -bound, bound)
            change[3:] = np.clip(change[3:], -LARGEST_CHANGE, LARGEST_CHANGE)
    box = change_box(change)
    last = compare(box, solid, find_correspondences(solid, seen, box), seen, known, tolerance)
    deviations = TOO_SURE * np.sqrt(np.diag(np.linalg.inv(curvature)))
    return FittedBox(box, deviations[:3], deviations[3:], last.cost)


def find_correspondences(solid: VisibleSolid, seen: SeenObject, box: UprightBox) -> Correspondences:
    """Points where rays from the camera to the seen points meet the model in `box`; for those whose rays miss it, the
    nearest of its surface in the unit box."""
    turn = yaw_matrix(box.yaw)
    origin, ends = (seen.eye - box.center) @ turn / box.size, (seen.points - box.center) @ turn / box.size
    rays = np.concatenate([np.broadcast_to(origin, ends.shape), ends - origin], axis=1).astype(np.float32)
    hits = solid.scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
    far, normals = hits["t_hit"].numpy(), hits["primitive_normals"].numpy().astype(float)
    missed = np.isinf(far)
    found = origin + rays[:, 3:] * np.where(missed, 0.0, far)[:, None]
    if missed.any():
        queries = o3d.core.Tensor.from_numpy(ends[missed].astype(np.float32))
        found[missed] = solid.scene.compute_closest_points(queries, nthreads=1)["points"].numpy()
        normals[missed] = (ends - found)[missed] * box.size**2  # in metres along what is between the two
    return found, normals


def compare(
    box: UprightBox, solid: VisibleSolid, on: Correspondences, seen: SeenObject, known: Prior, tolerance: float
) -> Deviations:
    """How far a box is off.

    Args:
        on: where on the model the object's points belong.
        tolerance: metres by which its surface may be another.
    """
    turn = yaw_matrix(box.yaw)
    terms: list[tuple[Array, float, float]] = []
    if seen.outline is not None:
        pixels = seen.project(solid.outermost * box.size @ turn.T + box.center)
        off = seen.outline.measure_misfit(pixels) / OUTLINE
        terms.append((off, INDEPENDENT_ENDS / DIRECTIONS, UNUSUAL))
    places, across = on
    normals = across / box.size
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True).clip(1e-12) @ turn.T
    apart = ((places * box.size @ turn.T + box.center - seen.points) * normals).sum(axis=1)
    noise = seen.noise * (normals * seen.rays).sum(axis=1)
    terms.append((apart / np.hypot(noise, tolerance), min(1.0, INDEPENDENT_POINTS / len(seen.points)), UNUSUAL))
    x, y, z = np.log(box.size / known.native)
    level = ROUND if known.is_round else PROPORTIONS
    prior = np.inf if known.is_round else UNUSUAL / 2
    terms.append((np.array([(x - y) / level, (z - (x + y) / 2) / PROPORTIONS]), 1.0, prior))
    if known.usual is not None:
        root = np.linalg.cholesky(np.linalg.inv(known.usual.covariance)).T
        terms.append((root @ (np.log(box.size) - known.usual.mean), 1.0, UNUSUAL / 2))
    if known.bottom is not None:
        terms.append((np.array([box.bottom - known.bottom]) / CONTACT_SPREAD, 1.0, np.inf))
    behind = np.array([_measure_behind(box, turn, wall) for wall in known.walls]) / CONTACT_SPREAD
    terms.append((np.maximum(behind, 0), 1.0, np.inf))
    before = np.array([_measure_behind(box, turn, wall) for wall in known.touched]) / CONTACT_SPREAD
    terms.append((np.minimum(before, 0), 1.0, UNUSUAL))
    counts = [len(off) for off, _, _ in terms]
    return Deviations(
        np.concatenate([off for off, _, _ in terms]),
        np.repeat([share for _, share, _ in terms], counts),
        np.repeat([unusual for _, _, unusual in terms], counts),
    )


def _measure_behind(box: UprightBox, turn: Array, wall: Wall) -> float:
    """Metres by which a box reaches behind a wall; negative: it ends before it."""
    normal = np.asarray(wall.normal)
    return float(wall.offset - box.center @ normal + np.abs(normal @ turn) @ box.size / 2)


def size(
    placed: Placed,
    yaw: float,
    one: MatchedObject,
    scene: Objects,
    category: CategoryFacts | None,
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
        bottom=None if placed.wall_mounted else placed.box.bottom,
        walls=[wall for wall in scene.walls if not is_behind(placed.box, wall.normal, wall.offset)],
        touched=reached,
    )
    seen = SeenObject(
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
