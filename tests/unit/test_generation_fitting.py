"""The box in which a model agrees with the picture: known answers."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.category import CategoryFacts, SizeSpread
from roomkin.stages.contracts.objects import DepthError, Wall
from roomkin.stages.generation import sizing
from roomkin.stages.generation.sizing import TOO_SURE, Prior, SeenObject, VisibleSolid, find_correspondences, fit_box
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import (
    Array,
    back_project,
    intrinsics_from_fov,
    make_transform,
    transform_points,
    yaw_matrix,
)
from roomkin.stages.geometry.masks import Outline, measure_outline
from roomkin.stages.geometry.solids import find_outermost
from tests.refusals import refused
from tests.unit.demo_assets import cabinet
from tests.unit.generation_scenes import BACK, thing

WIDTH, HEIGHT = 320, 240
K = intrinsics_from_fov(WIDTH, HEIGHT, 1.0)
AXES = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])  # camera x right, y down, z ahead; floor x ahead, z up
DOWN = np.array([[np.cos(0.35), 0, np.sin(0.35)], [0, 1, 0], [-np.sin(0.35), 0, np.cos(0.35)]])
POSE = make_transform(DOWN @ AXES, [0, 0, 1.5])
ERROR = DepthError(0.001, 0.001)
TRUE = UprightBox([3.2, 0.2, 0.35], [0.5, 0.9, 0.7], np.pi - 0.3)
BLOCK = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


class Block(VisibleSolid):
    """A model that fills its box."""

    def __init__(self) -> None:
        import open3d as o3d

        mesh = o3d.geometry.TriangleMesh.create_box()
        self.outermost = find_outermost(BLOCK)
        self.scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.scene.add_triangles(
            o3d.core.Tensor.from_numpy((np.asarray(mesh.vertices) - 0.5).astype(np.float32)),
            o3d.core.Tensor.from_numpy(np.asarray(mesh.triangles).astype(np.uint32)),
        )

    def cast(self, rays: Array) -> Array:
        """How far rays (N, 6) go until they meet it."""
        import open3d as o3d

        return self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays.astype(np.float32)))["t_hit"].numpy()


class Picture(NamedTuple):
    """Depth (H, W) of a box on a floor, and its mask."""

    depth: Array
    mask: np.ndarray


def draw(box: UprightBox = TRUE) -> Picture:
    rays = back_project(np.ones((HEIGHT, WIDTH)), K).reshape(-1, 3) @ POSE[:3, :3].T
    turn = yaw_matrix(box.yaw)
    ends = np.concatenate([np.broadcast_to(POSE[:3, 3] - box.center, rays.shape), rays], axis=1).reshape(-1, 2, 3)
    far = Block().cast((ends @ turn / box.size).reshape(-1, 6))
    mask = np.isfinite(far)
    floor = np.where(rays[:, 2] < 0, -POSE[2, 3] / np.minimum(rays[:, 2], -1e-9), 0)
    depth = np.where(mask, far, floor)
    return Picture(depth.reshape(HEIGHT, WIDTH), mask.reshape(HEIGHT, WIDTH))


def outline_of(mask: np.ndarray, depth: Array, inside: np.ndarray) -> Outline:
    """The outline where the floor hides nothing."""
    floor = transform_points(POSE, back_project(depth, K))[..., 2] < 0.01
    return measure_outline(mask, np.where(floor, np.inf, depth), inside, lambda far: 3 * ERROR.predict(far))


def see(picture: Picture, mask: np.ndarray | None = None) -> SeenObject:
    mask = picture.mask if mask is None else mask
    points = transform_points(POSE, back_project(picture.depth, K)[mask])[::7]
    outline = outline_of(mask, picture.depth, np.ones_like(mask))
    return SeenObject(POSE, K, outline, points, ERROR)


def known(native=(0.5, 0.9, 0.7), **values) -> Prior:
    return replace(Prior(np.array(native), False, None, 0.0, [], []), **values)


def test_outlines_are_made_of_the_outermost_points() -> None:
    assert len(find_outermost(np.concatenate([BLOCK, 0.5 * BLOCK]))) == 8
    flat = np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]])
    assert len(find_outermost(flat)) == 4  # a poster without thickness


def test_a_box_seen_whole_is_found_from_a_wrong_start() -> None:
    start = UprightBox([3.0, 0.1, 0.3], [0.3, 0.6, 0.6], TRUE.yaw)
    fit = fit_box(Block(), start, see(draw()), known(native=(0.3, 0.6, 0.4)))
    assert fit.box.size == pytest.approx(TRUE.size, abs=0.04)
    assert fit.box.center == pytest.approx(TRUE.center, abs=0.02)
    assert fit.spread.max() < 0.2 * TOO_SURE
    assert 0.01 < np.linalg.norm(fit.shift) < 0.06 * TOO_SURE


def test_points_whose_rays_miss_the_model_count_by_how_far_they_are_off() -> None:
    box = UprightBox([0.0, 0.0, 0.0], [2.0, 1.0, 1.0], 0.0)
    points = np.array([[0.2, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 0.9, 0.0]])
    seen = SeenObject(make_transform(np.eye(3), [0.0, 0.0, 3.0]), K, None, points, ERROR)
    places, across = find_correspondences(Block(), seen, box)
    np.testing.assert_allclose(places * box.size, [[1 / 6, 0, 0.5], [1, 0, 0], [0, 0.5, 0]], atol=1e-5)
    across = across / box.size
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    off = np.abs(((places * box.size - points) * across).sum(axis=1))
    assert off[1:] == pytest.approx([0.5, 0.4], abs=1e-5)


def test_a_model_does_not_shrink_until_the_rays_miss_it() -> None:
    seen, thin = see(draw()), UprightBox([2.9, 0.1, 0.35], [0.12, 0.9, 0.7], TRUE.yaw)
    assert fit_box(Block(), thin, seen, known(native=(0.12, 0.9, 0.7))).box.size == pytest.approx(TRUE.size, abs=0.06)


def test_what_the_border_cuts_is_as_large_as_usual_and_its_spread_says_so() -> None:
    picture = draw()
    columns = np.flatnonzero(picture.mask.any(axis=0))
    left = np.zeros_like(picture.mask)
    left[:, : int(columns.mean())] = True
    whole = see(picture)
    inside = outline_of(picture.mask & left, picture.depth, left)
    points = transform_points(POSE, back_project(picture.depth, K)[picture.mask & left])[::7]
    cut = SeenObject(POSE, K, inside, points, ERROR)
    usual = SizeSpread(np.log([0.5, 0.9, 0.7]), 0.15**2 * np.eye(3))
    seen_half = UprightBox(points.mean(axis=0) * [1, 1, 0] + [0, 0, 0.35], [0.5, 0.45, 0.7], TRUE.yaw)
    fit = fit_box(Block(), seen_half, cut, known(usual=usual))
    assert np.isinf(inside.limit).any() and not np.isinf(whole.outline.limit).any()
    assert fit.box.size[1] == pytest.approx(0.9, abs=0.1)  # half of it is seen
    best = fit_box(Block(), TRUE, whole, known(usual=usual))
    assert fit.spread[1] > 2 * best.spread[1] and np.linalg.norm(fit.shift) > 1.5 * np.linalg.norm(best.shift)


def test_what_hides_a_thing_says_how_far_it_goes_on_at_most() -> None:
    picture = draw()
    columns = np.flatnonzero(picture.mask.any(axis=0))
    post = np.zeros_like(picture.mask)
    post[:, columns[-1] - 20 : columns[-1] + 10] = True
    depth, mask = np.where(post, 1.0, picture.depth), picture.mask & ~post
    outline = outline_of(mask, depth, np.ones_like(mask))
    right, left = 0, 16  # of 32 directions
    assert outline.reach[right] < columns[-1] - 18
    assert columns[-1] <= outline.limit[right] < columns[-1] + 25
    assert outline.limit[left] == outline.reach[left] == pytest.approx(0.5 - columns[0])


def test_a_wall_that_is_touched_says_where_a_thing_ends() -> None:
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.5, points=100)
    box = UprightBox([3.2, 0, 0.35], [0.6, 0.9, 0.7], np.pi)
    picture = draw(box)
    fit = fit_box(Block(), UprightBox([3.1, 0, 0.35], [0.3, 0.9, 0.7], np.pi), see(picture), known(touched=[wall]))
    assert corners(fit.box)[:, 0].max() == pytest.approx(3.5, abs=0.01)
    assert fit.box.size == pytest.approx(box.size, abs=0.03)


def test_nothing_reaches_behind_a_wall() -> None:
    box = UprightBox([3.9, 0, 0.35], [0.6, 0.9, 0.7], np.pi)
    fit = fit_box(Block(), box, see(draw(box)), known(walls=[BACK]))
    assert corners(fit.box)[:, 0].max() < 4.03


def test_a_wall_holds_nothing_back_that_is_seen_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Through a door, say."""
    monkeypatch.setattr(sizing, "read_solid", lambda _: Block())
    seen, wall = see(draw()), Wall(id="wall_1", normal=(-1, 0, 0), offset=-2.0, points=100)
    one: Any = SimpleNamespace(cloud=seen.points, outline=seen.outline)
    scene: Any = SimpleNamespace(walls=[wall], floor_from_camera=POSE, intrinsics=K, depth_error=ERROR)
    start = thing("block", TRUE.center, TRUE.size, TRUE.yaw)
    found = sizing.size(start, TRUE.yaw, one, scene, None, [], GenerationConfig())
    assert found.box.center == pytest.approx(TRUE.center, abs=0.03)


def test_what_stands_on_a_table_ends_there() -> None:
    start, box = (UprightBox([3.2, 0.2, z], [0.5, 0.9, height], TRUE.yaw) for z, height in ((1.2, 0.4), (1.05, 0.7)))
    fit = fit_box(Block(), start, see(draw(box)), known(bottom=0.7))
    assert fit.box.bottom == pytest.approx(0.7, abs=0.005) and fit.box.size == pytest.approx(box.size, abs=0.03)


def test_sizes_of_a_category_have_a_mean_and_a_spread() -> None:
    assert CategoryFacts(name="mug", sizes=[(0.1, 0.1, 0.1)]).measure_spread() is None
    known = CategoryFacts(name="mug", sizes=[(0.1, 0.1, 0.1), (0.2, 0.2, 0.2)], real=[(0.4, 0.4, 0.4)])
    mean, covariance = known.measure_spread()
    assert np.exp(mean) == pytest.approx([0.2] * 3)
    assert covariance[0, 1] == pytest.approx(np.log(2) ** 2)  # larger mugs are higher, too
    assert covariance[0, 0] > covariance[0, 1]


def test_a_solid_is_where_the_model_is(tmp_path: Path) -> None:
    cabinet(tmp_path / "cabinet")
    sides = np.array([[0.0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    away = VisibleSolid(tmp_path / "cabinet").scene.cast_rays(
        np.concatenate([2 * sides, -sides], axis=1).astype(np.float32)
    )
    assert away["t_hit"].numpy() == pytest.approx([1.5] * 4, abs=1e-4), "its box is the unit box"


def test_a_model_that_is_not_whole_is_no_solid(tmp_path: Path) -> None:
    cabinet(tmp_path / "cabinet")
    assert len(VisibleSolid(tmp_path / "cabinet").visuals) > 1
    next((tmp_path / "cabinet/meshes").glob("*.obj")).unlink()
    with refused("E-MODEL-BROKEN"):
        VisibleSolid(tmp_path / "cabinet")
