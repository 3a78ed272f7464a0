"""Known answers of the geometry room."""

import numpy as np
import pytest

from roomkin.stages.geometry.boxes import (
    UprightBox,
    axis_aligned_iou,
    bounds,
    corners,
    distances_along,
    footprint,
    oriented_iou,
    surface_points,
)
from roomkin.stages.geometry.clouds import dbscan, farthest_points, minimum_box, statistical_inliers
from roomkin.stages.geometry.depth_forms import ray_lengths
from roomkin.stages.geometry.frames import (
    PointMap,
    angle_difference,
    back_project,
    intrinsics_from_fov,
    invert_transform,
    look_at,
    make_intrinsics,
    make_transform,
    project,
    quaternion_from_matrix,
    transform_points,
    wrap_angle,
    yaw_matrix,
    yaw_of_matrix,
    yaw_quaternion,
)
from roomkin.stages.geometry.room_planes import fit_plane


@pytest.mark.parametrize(
    ("angle", "period", "expected"),
    [
        (3 * np.pi, 2 * np.pi, np.pi),
        (-np.pi, 2 * np.pi, np.pi),
        (np.pi, np.pi / 2, 0.0),
        (1.0, np.pi / 2, 1 - np.pi / 2),
    ],
)
def test_wrap_angle(angle: float, period: float, expected: float) -> None:
    assert wrap_angle(angle, period) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("symmetry", "expected"),
    [("none", np.pi - 0.1), ("half_turn", 0.1), ("third_turn", np.pi / 3 - 0.1), ("quarter_turn", 0.1), ("full", 0.0)],
)
def test_angle_difference_knows_symmetry(symmetry: str, expected: float) -> None:
    assert angle_difference(np.pi, 0.1, symmetry) == pytest.approx(expected)


def test_quaternions_are_wxyz() -> None:
    np.testing.assert_allclose(quaternion_from_matrix(yaw_matrix(np.pi / 2)), [np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    np.testing.assert_allclose(yaw_quaternion(0.7), quaternion_from_matrix(yaw_matrix(0.7)))
    assert yaw_of_matrix(yaw_matrix(-2.0)) == pytest.approx(-2.0)


def test_rigid_inverse() -> None:
    transform = make_transform(yaw_matrix(0.4), [1.0, 2.0, 3.0])
    np.testing.assert_allclose(invert_transform(transform) @ transform, np.eye(4), atol=1e-12)
    np.testing.assert_allclose(
        transform_points(make_transform(yaw_matrix(np.pi / 2), [0, 0, 1]), [[1.0, 0, 0]]), [[0, 1, 1]], atol=1e-12
    )


def test_projection_undoes_back_projection() -> None:
    intrinsics = intrinsics_from_fov(8, 6, np.deg2rad(50))
    points = back_project(np.full((6, 8), 2.0), intrinsics)
    np.testing.assert_allclose(points[..., 2], 2.0)
    np.testing.assert_allclose(project(points[4, 7], intrinsics), [7, 4], atol=1e-9)
    assert np.isnan(project([0.0, 0.0, -1.0], intrinsics)).all()
    np.testing.assert_allclose(project([0.0, 0.0, 1.0], intrinsics), [3.5, 2.5])  # the middle of 8 x 6 pixels


def test_look_at_is_level_and_looks_forward() -> None:
    world_from_camera = look_at([0, 0, 1.5], [4, 0, 0.5])
    right, down, forward = world_from_camera[:3, :3].T
    assert right[2] == pytest.approx(0)
    assert down[2] < 0
    np.testing.assert_allclose(np.cross(right, down), forward, atol=1e-12)
    np.testing.assert_allclose(right, [0, -1, 0], atol=1e-12)


def test_corners_and_bounds_of_a_turned_box() -> None:
    box = UprightBox([1, 0, 0.5], [2, 1, 1], np.pi / 2)
    low, high = bounds(box)
    np.testing.assert_allclose([low, high], [[0.5, -1, 0], [1.5, 1, 1]], atol=1e-12)
    assert footprint(box).area == pytest.approx(2)
    assert corners(box)[:4, 2].max() == 0


def test_iou_of_known_boxes() -> None:
    cube = UprightBox([0, 0, 0], [1, 1, 1], 0.0)
    half = UprightBox([0.5, 0, 0], [1, 1, 1], 0.0)
    assert axis_aligned_iou(cube, half) == pytest.approx(1 / 3)
    assert oriented_iou(cube, half) == pytest.approx(1 / 3)
    turned = UprightBox([0, 0, 0], [1, 1, 1], np.pi / 4)
    octagon = 2 * (np.sqrt(2) - 1)  # area common to a unit square and itself turned by 45 degrees
    assert oriented_iou(cube, turned) == pytest.approx(octagon / (2 - octagon))
    assert axis_aligned_iou(cube, turned) == pytest.approx(0.5)
    for apart in ([1.5, 0, 0], [1.5, -1.5, 0], [1.5, 1.5, 1.5]):
        assert axis_aligned_iou(cube, UprightBox(apart, [1, 1, 1], 0.0)) == 0
    for height in (1.0, 1.5, -3.0):  # above each other
        assert oriented_iou(cube, UprightBox([0, 0, height], [1, 1, 1], 0.0)) == 0


@pytest.mark.parametrize("yaw", [0.0, 0.3, -0.6, np.pi / 4])
def test_minimum_box_of_a_turned_cuboid(yaw: float) -> None:
    expected = UprightBox([1.0, -2.0, 0.4], [0.9, 0.5, 0.8], yaw)
    unit = np.random.default_rng(0).uniform(-0.5, 0.5, (20_000, 3))
    box = minimum_box(unit * expected.size @ yaw_matrix(yaw).T + expected.center)
    assert abs(wrap_angle(box.yaw - yaw, np.pi / 2)) < np.deg2rad(0.3)
    np.testing.assert_allclose(box.center, expected.center, atol=0.003)
    np.testing.assert_allclose(sorted(box.size), sorted(expected.size), atol=0.01)
    assert -np.pi / 4 < box.yaw <= np.pi / 4


@pytest.mark.parametrize("yaw", np.deg2rad([-30.0, 0.0, 20.0]))
def test_minimum_box_of_two_visible_sides(yaw: float) -> None:
    """Seen from above, two sides are an L, whose smallest rectangle is not unique."""
    rng = np.random.default_rng(1)
    along = rng.random(4000)
    plan = np.where(rng.random(4000)[:, None] < 0.6, np.c_[0.7 * along, 0 * along], np.c_[0 * along, 0.4 * along])
    points = np.c_[plan, rng.random(4000)] + rng.normal(0, 0.004, (4000, 3))
    box = minimum_box(points @ yaw_matrix(yaw).T, trim=0.005)
    assert box.yaw == pytest.approx(yaw, abs=np.deg2rad(1))
    np.testing.assert_allclose(np.asarray(box.size)[:2], [0.7, 0.4], atol=0.03)


def test_minimum_box_trims_stray_points() -> None:
    points = np.vstack([np.random.default_rng(0).uniform(0, 1, (5000, 3)), [[9.0, 9.0, 9.0]]])
    assert np.asarray(minimum_box(points, trim=0.001).size).max() < 1.01
    assert np.asarray(minimum_box(points).size)[2] > 8


def test_minimum_box_of_a_single_point() -> None:
    np.testing.assert_allclose(minimum_box(np.array([[1.0, 2.0, 3.0]])).center, [1, 2, 3], atol=1e-9)


def test_plane_among_outliers_is_found_and_repeatable() -> None:
    rng = np.random.default_rng(3)
    plane = np.c_[rng.uniform(-2, 2, (2000, 2)), np.zeros(2000)]
    plane[:, 2] = 0.1 * plane[:, 0] + 0.5 + rng.normal(0, 0.005, 2000)
    points = np.vstack([plane, rng.uniform(-2, 2, (3000, 3))])
    first, second = (fit_plane(points, 0.02, 300, np.random.default_rng(0)) for _ in range(2))
    assert first is not None and second is not None
    expected = np.array([-0.1, 0, 1]) / np.sqrt(1.01)
    assert abs(first.normal @ expected) > np.cos(np.deg2rad(0.3))
    assert first.inliers[:2000].mean() > 0.99
    np.testing.assert_array_equal(first.normal, second.normal)


def test_plane_keeps_to_plausible_normals() -> None:
    rng = np.random.default_rng(4)
    wall = np.c_[np.zeros(3000), rng.uniform(0, 3, (3000, 2))]
    floor = np.c_[rng.uniform(0, 3, (1000, 2)), np.zeros(1000)]
    plane = fit_plane(np.vstack([wall, floor]), 0.02, 300, rng, plausible=lambda normals: np.abs(normals[:, 2]) > 0.9)
    assert plane is not None and abs(plane.normal[2]) > 0.99
    assert fit_plane(wall[:2], 0.02, 10, rng) is None


def test_refinement_does_not_leave_the_plausible_normals() -> None:
    """Points along a line fit any plane through it; the least squares one is not level here."""
    rng = np.random.default_rng(5)
    line = rng.uniform([-1, -0.001, -0.004], [1, 0.001, 0.004], (500, 3))
    plane = fit_plane(line, 0.02, 300, rng, plausible=lambda normals: np.abs(normals[:, 2]) > 0.9)
    assert plane is not None and abs(plane.normal[2]) > 0.9


@pytest.mark.parametrize("deviations", [1.0, 3.0, 6.0])
def test_statistical_inliers_are_those_of_the_definition(deviations: float) -> None:
    points = np.random.default_rng(0).normal(size=(400, 3))
    distances = np.sort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, 1:11].mean(axis=1)
    limit = distances.mean() + deviations * distances.std(ddof=1)
    np.testing.assert_array_equal(statistical_inliers(points, 10, deviations), distances < limit)
    assert statistical_inliers(points[:9], 10, deviations).all()


def test_dbscan_tells_clusters_from_noise() -> None:
    rng = np.random.default_rng(0)
    clumps = [rng.uniform([x, 0, 0], [x + 0.1, 0.1, 0.1], (40, 3)) for x in (0.0, 1.0)]
    labels = dbscan(np.vstack([*clumps, [[0.5, 0, 0]]]), 0.1, 8)
    assert {*labels[:40]} == {labels[0]} and {*labels[40:80]} == {labels[40]}
    assert labels[0] != labels[40] and min(labels[0], labels[40]) >= 0 and labels[80] == -1


def test_farthest_points_are_those_of_the_definition() -> None:
    points = np.random.default_rng(0).random((300, 3)).astype(np.float32)
    chosen = [0]
    while len(chosen) < 20:
        chosen.append(int(np.linalg.norm(points[:, None] - points[chosen], axis=2).min(axis=1).argmax()))
    np.testing.assert_array_equal(farthest_points(points, 20), points[np.sort(chosen)])
    assert farthest_points(np.ones((2, 3), np.float32), 5).shape == (5, 3)
    assert not farthest_points(np.zeros((0, 3), np.float32), 5).any()


def test_rays_meet_boxes_before_them_alone() -> None:
    box, eye = UprightBox([3.0, 0, 1], [1, 2, 1], np.pi / 2), np.array([0.0, 0, 1])  # turned: 2 m along x
    rays = np.array([[1.0, 0, 0], [0.5, 0, 0], [-1, 0, 0], [1, 1, 0], [1, 0.2, 0], [0, 0, 1]])
    assert distances_along(eye, rays, box) == pytest.approx([2, 4, np.inf, np.inf, 2, np.inf])
    assert np.isinf(distances_along(box.center, rays, box)).all()  # whoever is in it does not see it


def test_points_are_in_its_frame_where_depth_is_known() -> None:
    depth = np.array([[2.0, 0.0], [1.0, 4.0]], np.float32)
    seen = PointMap(
        depth, make_intrinsics(2, 2, 0, 0), make_transform([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], [0, 0, 1.5])
    )
    np.testing.assert_allclose(seen.points[1, 1], [4, -2, -0.5])
    assert np.isnan(seen.points[0, 1]).all()
    np.testing.assert_allclose(seen.of(np.array([[True, True], [False, True]])), [[2, 0, 1.5], [4, -2, -0.5]])


def test_rays_are_longer_the_farther_they_are_from_the_middle() -> None:
    lengths = ray_lengths((6, 6), make_intrinsics(2, 4, 3, 1))
    ends = {(1, 3): 1.0, (1, 5): 2**0.5, (1, 1): 2**0.5, (5, 3): 2**0.5, (5, 5): 3**0.5}
    assert {place: lengths[place] for place in ends} == pytest.approx(ends)


def test_a_plate_has_points_on_its_two_faces_and_on_no_other_level() -> None:
    points = surface_points(UprightBox([0.0, 0.0, 0.5], [1.0, 2.0, 0.001], 0.0), 200)
    assert set(points[:, 2].round(6)) == {0.4995, 0.5005} and len(points) == pytest.approx(200, rel=0.1)
