"""Yaw and extents of a placed asset: known answers."""

import numpy as np
import pytest
import trimesh

from stages.config.generation import GenerationConfig
from stages.contracts import Objects
from stages.contracts.objects import USUAL_ERROR, Box, DepthError, Mounting, SceneObject, Wall
from stages.generation.choosing import measure_stretch
from stages.generation.inputs import find_bearings
from stages.generation.mounting import correct_depth_at_wall
from stages.generation.placing import reaches_walls
from stages.generation.sizing import (
    correct_depth_in_room,
    make_round,
    measure_beyond_front,
    sight_yaw,
    widen_to_outline,
)
from stages.generation.turning import find_wall_axes, measure_rectangularity, pick_rear_at_wall, turn_to
from stages.geometry.boxes import UprightBox
from stages.geometry.cameras import intrinsics_from_fov, look_at, project
from stages.geometry.estimate import Sight, correct_depth, find_near_face
from stages.geometry.frames import apply, inverse, wrap_angle, yaw_matrix
from stages.geometry.viewing import view_yaw

DEGREE = np.pi / 180
EXACT = DepthError(0, 0)
BELIEVABLE = GenerationConfig().aspect_range


@pytest.mark.parametrize(
    ("center", "psi", "expected"),
    [
        ((3, 0, 0), 0.0, 180),  # straight ahead, front to the camera: looks back along -x
        ((3, 0, 0), 90 * DEGREE, -90),
        ((0, 3, 0), 0.0, -90),  # to the left, still facing the camera
        ((3, 3, 0), 0.0, -135),
        ((3, -3, 1), 45 * DEGREE, 180),
    ],
)
def test_view_yaw(center, psi, expected):
    assert wrap_angle(view_yaw((0, 0, 1.6), center, psi) - expected * DEGREE) == pytest.approx(0, abs=1e-9)


def test_turned_to_the_nearest_quarter_of_the_frame():
    assert turn_to(100 * DEGREE, 5 * DEGREE) == pytest.approx(95 * DEGREE)
    assert turn_to(-80 * DEGREE, 5 * DEGREE) == pytest.approx(-85 * DEGREE)
    assert turn_to(175 * DEGREE, -3 * DEGREE) == pytest.approx(177 * DEGREE)


def test_a_turn_beyond_the_limit_is_not_made():
    assert turn_to(30 * DEGREE, 0.0, 20 * DEGREE) == pytest.approx(30 * DEGREE)
    assert turn_to(19 * DEGREE, 0.0, 20 * DEGREE) == pytest.approx(0, abs=1e-12)
    assert turn_to(30 * DEGREE, 0.0, None) == pytest.approx(0, abs=1e-12)


def test_wall_axes_is_the_angle_of_the_normal():
    assert find_wall_axes((-1, 0, 0)) == pytest.approx(np.pi)
    assert turn_to(170 * DEGREE, find_wall_axes((-1, 0, 0))) == pytest.approx(np.pi)


def test_of_several_views_the_one_with_its_rear_to_the_wall():
    back, side = (-1, 0, 0), (0, 1, 0)  # normals of two walls; fronts look along them
    assert pick_rear_at_wall([0.0, 1.5, 3.0], [back]) == 3.0
    assert pick_rear_at_wall([0.0, 1.5, 3.0], [back, side]) == 1.5
    assert pick_rear_at_wall([0.0, 0.5], [back]) == 0.0
    assert pick_rear_at_wall([0.4, 0.5], []) == 0.4


def test_rectangularity_tells_boxes_from_round_things():
    rng = np.random.default_rng(0)
    square = rng.uniform(-0.5, 0.5, (4000, 3)) @ yaw_matrix(0.3).T
    angle, radius = rng.uniform(0, 2 * np.pi, 4000), 0.5 * np.sqrt(rng.uniform(0, 1, 4000))
    disc = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(4000)], axis=1)
    corner = np.array([(x, 0, 0) for x in np.linspace(0, 1, 200)] + [(0, y, 0) for y in np.linspace(0, 1, 200)])
    assert measure_rectangularity(square, 0.3) > 0.85
    assert measure_rectangularity(square, 0.3 + np.pi / 4) < 0.2
    assert measure_rectangularity(disc, 0.0) < 0.4
    assert 0.5 < measure_rectangularity(corner, 0.0) < 0.65
    assert measure_rectangularity(np.zeros((5, 3)), 0.0) == 0.0


def test_a_noisy_face_is_where_it_is_densest():
    rng = np.random.default_rng(1)
    face = rng.normal(2.0, 0.02, 4000)  # the front, 2 m away, seen along the axis
    side = rng.uniform(2.0, 2.6, 1000)
    values = np.concatenate([face, side])
    assert find_near_face(values, -1, 0.02, 0.005) == pytest.approx(2.0, abs=0.01)
    assert np.quantile(values, 0.005) < 1.96  # what the plain quantile makes of it
    assert find_near_face(-values, 1, 0.02, 0.005) == pytest.approx(-2.0, abs=0.01)


def test_a_face_far_away_is_looked_for_as_far_as_noise_reaches():
    rng = np.random.default_rng(1)
    values = np.concatenate([rng.normal(11.0, 0.2, 4000), rng.uniform(11.0, 12.5, 1000) + rng.normal(0, 0.2, 1000)])
    assert find_near_face(values, -1, 0.2, 0.005) == pytest.approx(11.0, abs=0.05)


def test_a_top_seen_from_above_has_no_face():
    assert find_near_face(np.random.default_rng(2).uniform(0, 1, 5000), -1, 0.02, 0.01) is None


def test_noise_does_not_make_a_table_longer():
    rng, camera = np.random.default_rng(4), np.array([0, 0, 1.6])
    top = np.array([8.0, 0, 0.7]) + rng.uniform([-0.5, -0.5, 0], [0.5, 0.5, 0], (8000, 3))
    noisy = top + rng.normal(0, 0.1, (8000, 1)) * (top - camera) / np.linalg.norm(top - camera, axis=1, keepdims=True)
    seen = UprightBox((8.0, 0, 0.35), (1.0, 1.0, 0.7), 0.0)
    as_in_the_paper = Sight(noisy, camera, EXACT.predict).measure_box(seen, 0.0, 0.005, has_faces=False)
    assert as_in_the_paper.size[0] > 1.2
    box = Sight(noisy, camera, DepthError(0.004, 0.0015).predict).measure_box(seen, 0.0, 0.005)
    assert box.size[0] == pytest.approx(1.1, abs=0.1)


@pytest.mark.parametrize(("x", "side", "unknown"), [(10.0, 0.0, True), (10.0, 1.2, False), (3.0, 0.0, False)])
def test_the_depth_of_a_face_far_away_is_noise(x, side, unknown):
    """A front, with a side or without; near enough its noise tells nothing wrong."""
    rng, camera = np.random.default_rng(5), np.array([0, 0, 1.6])
    front = rng.uniform([x, -0.8, 0], [x, 0.8, 2], (4000, 3))
    cloud = np.concatenate([front, rng.uniform([x, 0.8, 0], [x + side, 0.8, 2], (3000, 3))])
    rays = (cloud - camera) / np.linalg.norm(cloud - camera, axis=1, keepdims=True)
    cloud = cloud + rng.normal(0, 0.003 + 0.0015 * x**2, (len(cloud), 1)) * rays
    normal = np.array([-1.0, 0, 0])
    assert Sight(cloud, camera, USUAL_ERROR.predict).is_one_face(normal) == unknown
    assert not Sight(cloud, camera, EXACT.predict).is_one_face(normal)


def _faces(size, yaw, center, camera, count=3000):
    """Points on the two upright faces of a box that a camera sees, and on its top."""
    rng = np.random.default_rng(3)
    half = np.asarray(size) / 2
    to_camera = (np.asarray(camera) - center) @ yaw_matrix(yaw)
    parts = []
    for axis in range(3):
        part = rng.uniform(-half, half, (count, 3))
        part[:, axis] = half[axis] * np.sign(to_camera[axis])
        parts.append(part)
    return np.concatenate(parts) @ yaw_matrix(yaw).T + center


@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_measured_box_in_the_assets_own_axes(quarter):
    size, center, camera = np.array([0.6, 1.2, 0.8]), np.array([3.0, 0.5, 0.4]), np.array([0, 0, 1.6])
    cloud = _faces(size, 0.4, center, camera)
    seen = UprightBox(center, size, 0.4)
    box = Sight(cloud, camera, USUAL_ERROR.predict).measure_box(seen, 0.4 + quarter * np.pi / 2, 0.001)
    expected = size[[1, 0, 2]] if quarter % 2 else size
    assert box.size == pytest.approx(expected, abs=0.02)
    assert box.center == pytest.approx(center, abs=0.02)


@pytest.mark.parametrize(("quarter", "nearer"), [(2, 0.04), (0, 0.0)])  # its front to the camera, and its rear
def test_a_handle_stands_before_the_face_that_is_measured(quarter, nearer):
    size, center, camera = np.array([0.6, 1.2, 0.8]), np.array([3.0, 0.0, 0.4]), np.array([0, 0, 1.6])
    cloud, seen = _faces(size, 0.0, center, camera), UprightBox(center, size, 0.0)
    plain, handled = (
        Sight(cloud, camera, USUAL_ERROR.predict).measure_box(seen, quarter * np.pi / 2, 0.001, beyond=beyond)
        for beyond in (0, 0.04)
    )
    assert handled.size[0] - plain.size[0] == pytest.approx(nearer)
    assert plain.center[0] - handled.center[0] == pytest.approx(nearer / 2)
    assert (handled.size[1], handled.center[1]) == pytest.approx((plain.size[1], plain.center[1]))


def test_what_is_round_has_no_face():
    """Its near end is where its points end: here a front of 1 cm, and behind it a step where most points are."""
    camera, seen = np.array([0, 0, 0.5]), UprightBox((3, 0, 0.5), (0.4, 0.4, 0.4), 0.0)
    rng = np.random.default_rng(0)
    near, step = (rng.uniform(-0.2, 0.2, (count, 3)) + np.array([3, 0, 0.5]) for count in (200, 2000))
    near[:, 0], step[:, 0] = rng.uniform(2.8, 2.81, 200), 2.81
    far = np.array([[3.2, 0, 0.5]] * 200)
    cloud = np.concatenate([near, step, far])
    ends = [Sight(cloud, camera, EXACT.predict).measure_box(seen, 0.0, 0.001, has_faces) for has_faces in (True, False)]
    starts = [box.center[0] - box.size[0] / 2 for box in ends]
    assert starts == pytest.approx([2.81, 2.80], abs=0.004)


def test_a_round_thing_is_as_wide_as_its_outline():
    """A cylinder of radius 0.2 at 45 degrees from a camera beside the origin; its points end short of the outline."""
    camera, center, yaw = np.array([1.0, 0, 1.5]), np.array([3.0, 2.0, 0.5]), np.pi / 4
    distance, half = np.sqrt(8), np.arcsin(0.2 / np.sqrt(8))
    narrow = UprightBox(center + 0.03 * yaw_matrix(yaw)[:, 1], (0.2, 0.34, 1.0), yaw)
    box = widen_to_outline(narrow, camera, (yaw - half, yaw + half))
    assert box.size == pytest.approx([0.2, 0.4, 1.0], abs=1e-3)
    assert box.center == pytest.approx(center, abs=2e-3)
    hidden = widen_to_outline(narrow, camera, (yaw - half / 2, yaw + half / 2))
    assert hidden is narrow and distance > 2


def test_bearings_of_an_object_from_its_mask():
    """A pole 0.2 wide, 4 m ahead along y of a camera that looks down on its middle."""
    intrinsics, pose = intrinsics_from_fov(400, 300, 1.0), look_at([0, 0, 1.5], [0, 4, 0.5])
    pixels = project(apply(inverse(pose), np.array([(-0.1, 4, 0.5), (0.1, 4, 0.5)])), intrinsics)
    masks = np.zeros((300, 400), np.uint16)
    masks[148:151, round(pixels[:, 0].min() + 0.5) : round(pixels[:, 0].max() + 0.5)] = 7
    box = Box(center=(0, 4, 0.5), size=(0.2, 0.2, 1), yaw=0)
    item = SceneObject(id="pole_1", label="pole", mask=7, box=box, mounting=Mounting(type=2))
    scene = Objects(
        scene="s", width=400, height=300, intrinsics=intrinsics.tolist(), floor_from_camera=pose.tolist(), walls=[],
        objects=[item],
    )  # fmt: skip
    low, high = find_bearings(scene, masks)["pole_1"]
    assert (low, high) == pytest.approx((np.pi / 2 - 0.025, np.pi / 2 + 0.025), abs=0.003)


def test_how_far_a_model_reaches_beyond_its_front():
    body, handle = trimesh.creation.box((0.5, 1.0, 0.8)), trimesh.creation.box((0.04, 0.1, 0.02))
    handle.apply_translation((0.27, 0.3, 0.2))
    assert measure_beyond_front([body]) == 0
    assert measure_beyond_front([body, handle]) == pytest.approx(0.04, abs=1e-6)
    rear, board = trimesh.creation.box((0.02, 1.0, 0.8)), trimesh.creation.box((0.5, 1.0, 0.02))
    rear.apply_translation((-0.24, 0, 0))
    assert measure_beyond_front([rear, board, handle]) == 0  # open shelves: nothing fills the front


def test_heights_are_those_of_extraction():
    cloud = _faces((0.4, 0.4, 0.4), 0.0, np.array([2, 0, 0.8]), np.array([0, 0, 1.6]))
    box = Sight(cloud, np.array([0, 0, 1.6]), EXACT.predict).measure_box(
        UprightBox((2, 0, 0.5), (0.4, 0.4, 1.0), 0.0), 0.2, 0.0
    )
    assert box.size[2] == 1.0
    assert box.center[2] == 0.5


def test_unseen_depth_comes_from_the_asset_and_the_front_stays():
    flat = UprightBox((2.0, 0, 0.5), (0.1, 1.0, 1.0), np.pi)  # front at x = 1.95, facing the camera
    box = correct_depth(flat, (0.5, 1.0, 1.0), (-1, 0), (0.5, 2.0))
    assert box.size == pytest.approx([0.5, 1.0, 1.0])
    assert box.center == pytest.approx([2.2, 0, 0.5])


def test_depth_at_a_wall_grows_from_the_wall():
    flat = UprightBox((2.95, 0, 0.5), (0.1, 1.0, 1.0), np.pi)  # rear at x = 3.0
    box = correct_depth(flat, (0.5, 1.0, 1.0), (1, 0), (0.5, 2.0))
    assert box.center == pytest.approx([2.75, 0, 0.5])


def test_depth_that_is_seen_from_above_stays():
    """A cereal box on a table: its top is seen from front to rear, and no box of the library is as flat."""
    rng, camera, error = np.random.default_rng(0), np.array([0.0, 0, 0.6]), USUAL_ERROR
    flat = UprightBox((0.6, 0, 0.105), (0.06, 0.16, 0.21), 0.0)
    half = np.array(flat.size) / 2
    top, front = rng.uniform(-half, half, (2, 2000, 3))
    top[:, 2], front[:, 0] = half[2], -half[0]
    cloud = np.concatenate([top, front]) + flat.center + rng.normal(0, 0.001, (4000, 3))
    native = (0.3, 0.3, 0.3)

    def sight(points=cloud, eye=camera, depth_error=error):
        return Sight(points, np.array(eye), depth_error.predict)

    assert correct_depth_in_room(flat, native, sight(), BELIEVABLE) is flat
    front_half = cloud[(cloud[:, 0] < 0.6) | (cloud[:, 2] < 0.15)]
    assert not sight(front_half).sees_top(flat), "its rear half is not"
    assert not sight(eye=[0, 0, 0.2]).sees_top(flat), "from below"
    assert not sight(depth_error=DepthError(0.02, 0)).sees_top(flat), "noise"
    of_front = correct_depth_in_room(flat, native, sight(cloud[2000:]), BELIEVABLE)
    assert of_front.size[0] == pytest.approx(0.16, abs=0.01), "of its front alone"


def test_a_width_is_never_changed():
    wide = UprightBox((2, 0, 0.5), (0.5, 4.0, 1.0), 0.0)
    assert correct_depth(wide, (0.5, 1.0, 1.0), (-1, 0.2), (0.5, 2.0)) is wide


def test_believable_proportions_are_kept():
    stretched = UprightBox((2, 0, 0.5), (0.6, 1.9, 1.0), 0.3)
    box = correct_depth(stretched, (0.5, 1.0, 1.0), (-1, 0), (0.5, 2.0))
    assert box.size == pytest.approx([0.6, 1.9, 1.0])
    assert box.center == pytest.approx([2, 0, 0.5])


def test_round_things_are_as_deep_as_wide():
    assert sight_yaw(UprightBox((0, 2, 0), (1, 1, 1), 0), (0, 0, 1)) == pytest.approx(np.pi / 2)
    half_seen = make_round(UprightBox((0.1, 0, 0.1), (0.2, 0.4, 0.2), 0.0), (0.5, 2.0))  # near end at x = 0
    assert half_seen.size == pytest.approx([0.4, 0.4, 0.2])
    assert half_seen.center == pytest.approx([0.2, 0, 0.1])
    noisy = make_round(UprightBox((0.3, 0, 0.1), (0.6, 0.4, 0.2), 0.0), (0.5, 2.0))  # noise at either end
    assert noisy.center == pytest.approx([0.3, 0, 0.1])
    smeared = make_round(UprightBox((1.0, 0, 0.1), (2.0, 0.4, 0.2), 0.0), (0.5, 2.0))  # background behind it
    assert smeared.center == pytest.approx([0.2, 0, 0.1])


def test_what_stands_on_furniture_or_is_round_is_not_extended_to_the_wall():
    low, high = UprightBox((3.5, 0, 0.4), (0.4, 0.4, 0.8), 0.0), UprightBox((3.5, 0, 1.0), (0.4, 0.4, 0.4), 0.0)
    stands, hangs = Mounting(type=3, walls=["wall_1"]), Mounting(type=1, walls=["wall_1"])
    assert reaches_walls(stands, low, False)
    assert not reaches_walls(stands, high, False)
    assert not reaches_walls(stands, low, True)
    assert reaches_walls(hangs, high, False)


@pytest.mark.parametrize(
    ("size", "stays"),
    [((0.9, 2.2, 0.8), True), ((1.1, 2.0, 1.0), True), ((0.4, 0.4, 0.5), False), ((0.3, 0.73, 0.27), False)],
)
def test_a_sofa_is_no_stool(size, stays):
    box = UprightBox((0, 0, 0), size, 0.0)
    assert (measure_stretch((0.9, 2.2, 0.8), box) <= 2.0) == stays


@pytest.mark.parametrize(
    ("mounting", "front", "size", "x"),
    [(3, 2.4, 0.5, 2.65), (3, 3.9, 0.5, 3.75), (1, 2.4, 0.5, 3.75), (3, 3.4, 0.6, 3.7)],
)
def test_what_is_far_too_deep_to_reach_its_wall_stands_before_it(mounting, front, size, x):
    """The wall x = 4: too deep, and its front stays; too shallow, and its rear does; what hangs stays at the wall."""
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=9)
    box = UprightBox(((front + 4) / 2, 0, 0.5), (4 - front, 1.0, 1.0), np.pi)
    near = np.array([[front, 0.0, 0.5]])
    sight = Sight(near, np.array([2.0, 0, 1.6]), USUAL_ERROR.predict)
    placed = correct_depth_at_wall(box, (0.5, 1.0, 1.0), sight, BELIEVABLE, wall, hangs=mounting == 1)
    assert placed.size[0] == pytest.approx(size)
    assert placed.center[0] == pytest.approx(x)


@pytest.mark.parametrize(("away", "seen"), [(2.0, True), (12.0, False)])
def test_the_depth_of_a_top_far_away_is_noise(away, seen):
    """Noise grows with the square of the distance: six deviations of it are more than a small top is deep."""
    camera, box = np.array([0.0, 0.0, 0.5 + away]), UprightBox((away, 0, 0.25), (0.5, 0.5, 0.5), 0.0)
    top = np.random.default_rng(6).uniform([away - 0.25, -0.25, 0.5], [away + 0.25, 0.25, 0.5], (4000, 3))
    assert Sight(top, camera, USUAL_ERROR.predict).sees_top(box) == seen
    assert Sight(top, camera, EXACT.predict).sees_top(box)
