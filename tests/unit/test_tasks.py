"""What a task is made of, without a simulator: randomisation, kinematics, handles, observations."""

import atexit
import gc

import numpy as np
import pytest
import trimesh

from roomkin.stages.articulated.handle import find_handle
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.geometry.frames import make_transform, yaw_matrix
from roomkin.stages.simulation import observation
from roomkin.stages.simulation.kinematics import jacobian, pose_error, track
from roomkin.stages.simulation.robot import REST, apply_delta, panda_chain, rest_quaternion, scale_action
from roomkin.stages.simulation.target import Target
from roomkin.stages.tasks import api
from roomkin.stages.tasks.initial_state import (
    base_pose,
    nominal_root,
    object_motion,
    sample_initial_state,
    variant_scale,
)
from roomkin.stages.tasks.observation import WRIST, jitter, other_shoulder, shoulder
from tests.unit.generation_scenes import asset

STILL = TaskConfig(base_xy=0, base_z=0, base_yaw=0, object_xy=0, object_yaw=0, qpos_noise=0, camera_jitter=(0, 0))


def test_an_episode_follows_from_its_seed() -> None:
    options = TaskConfig()
    once, again, other = (sample_initial_state(seed, options) for seed in (2**31 + 5, 2**31 + 5, 6))
    assert np.array_equal(once.joints, again.joints) and once.base_yaw == again.base_yaw
    assert not np.array_equal(once.base_offset, other.base_offset)
    assert np.abs(once.base_offset[:2]).max() <= options.base_xy


def test_scales_stay_in_their_range_and_differ() -> None:
    scales = np.array([variant_scale(variant, (0.8, 0.9)) for variant in range(8)])
    assert scales.min() >= 0.8 and scales.max() <= 0.9
    assert len(np.unique(scales[:, 0])) > 1


def test_the_robot_stands_in_front_of_the_handle_and_faces_it() -> None:
    handle = np.array([0.2, -0.1, 0.5])
    pose = base_pose(handle, -1.0, sample_initial_state(0, STILL), STILL)
    seen = np.linalg.inv(pose) @ np.append(handle, 1.0)
    assert seen[:3] == pytest.approx([STILL.base_distance, -STILL.base_side, STILL.handle_height])


def test_the_object_is_turned_and_shifted_by_what_was_drawn() -> None:
    setup = sample_initial_state(3, TaskConfig(object_yaw=0.3, object_xy=0.1))
    motion = object_motion(setup)
    assert abs(setup.object_yaw) > 0.01
    assert motion[:3, 0] == pytest.approx([np.cos(setup.object_yaw), np.sin(setup.object_yaw), 0.0])
    assert motion[:3, 3] == pytest.approx([*setup.object_offset, 0.0])


@pytest.mark.parametrize("revolute", [True, False])
def test_motions_start_where_the_joint_is_closed(revolute: bool) -> None:
    """A joint whose range does not start at 0: closed is no motion at all."""
    mesh, z = trimesh.creation.box((0.1, 0.1, 0.1)), np.array([0.0, 0.0, 1.0])
    target = Target(0, revolute, z, np.array([0.5, 0.0, 0.0]), -0.4, 1.0, mesh, mesh, None)
    closed, opened = target.motions(np.array([-0.4, -0.1]))
    assert closed == pytest.approx(np.eye(4))
    moved = opened @ [0.5, 0.2, 0.0, 1.0]
    assert moved[:3] == pytest.approx([0.5 - 0.2 * np.sin(0.3), 0.2 * np.cos(0.3), 0] if revolute else [0.5, 0.2, 0.3])


def test_cameras_look_at_their_targets() -> None:
    for camera in (shoulder(STILL), other_shoulder(STILL), WRIST):
        pose = camera.pose()
        towards = np.subtract(camera.target, camera.eye)
        assert pose[:3, 0] == pytest.approx(towards / np.linalg.norm(towards))
        assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    left, right = shoulder(STILL).pose(), other_shoulder(STILL).pose()
    assert left[:3, 3] * [1, -1, 1] == pytest.approx(right[:3, 3])
    assert left[:3, 0] * [1, -1, 1] == pytest.approx(right[:3, 0])


def test_cameras_are_jittered_each_on_its_own_and_within_bounds() -> None:
    options = TaskConfig(camera_jitter=(0.01, 0.1))
    shifts = np.array([[jitter(seed, number, options) for number in range(2)] for seed in range(30)])
    assert 0.008 < np.abs(shifts[..., :3, 3]).max() <= 0.01
    angles = np.arccos((np.trace(shifts[..., :3, :3], axis1=-2, axis2=-1) - 1) / 2)
    assert 0.08 < angles.max() <= 0.1 + 1e-6
    assert not np.allclose(shifts[:, 0], shifts[:, 1])
    assert jitter(3, 0, STILL) == pytest.approx(np.eye(4))


def test_the_rest_pose_is_where_it_says() -> None:
    pose = panda_chain().pose(REST[None])[0]
    assert pose[:3, 3] == pytest.approx([0.42, 0.0, 0.55], abs=2e-3)
    assert pose[:3, 2] == pytest.approx([np.cos(0.7), 0.0, -np.sin(0.7)], abs=2e-3)


def test_the_jacobian_is_the_derivative_of_the_pose() -> None:
    chain, q, step = panda_chain(), REST + 0.1 * np.arange(7), 1e-6
    J = jacobian(chain.frames(q[None]))[0]
    for joint in range(7):
        moved = q + step * np.eye(7)[joint]
        change = pose_error(chain.pose(moved[None]), chain.pose(q[None]))[0] / step
        assert change == pytest.approx(J[:, joint], abs=1e-4)


def test_tracking_reaches_a_near_pose_and_keeps_the_limits() -> None:
    chain = panda_chain()
    target = apply_delta(chain.pose(REST[None]), np.array([[0.03, -0.02, 0.02, 0.0, 0.1, 0.1]]))
    q = track(chain, REST[None], target)
    assert np.abs(pose_error(target, chain.pose(q))).max() < 1e-3
    near = np.clip(REST, chain.lower + 0.05, chain.upper - 0.05)
    for joint, limit in ((0, chain.upper), (3, chain.lower), (5, chain.upper)):
        start, beyond = near.copy(), near.copy()
        start[joint], beyond[joint] = limit[joint] - np.sign(limit[joint]) * 0.05, limit[joint] + np.sign(limit[joint])
        q = track(chain, start[None], chain.pose(beyond[None]), iterations=50)[0]
        assert (q > chain.lower).all() and (q < chain.upper).all(), joint


def test_an_action_is_clipped_per_axis_and_by_its_turn() -> None:
    scaled = scale_action(np.array([[2.0, -0.5, 0.0, 3.0, 4.0, 0.0]]), 0.05, 0.2)[0]
    assert scaled == pytest.approx([0.05, -0.025, 0.0, 0.12, 0.16, 0.0])


def panel(*parts: tuple[tuple[float, float, float], tuple[float, float, float]]) -> trimesh.Trimesh:
    """A 2 cm panel, 0.4 x 0.6 m, its front at x = 0, with boxes (extents, center) on it."""
    boxes = [((0.02, 0.4, 0.6), (-0.01, 0.0, 0.0)), *parts]
    return trimesh.util.concatenate([trimesh.creation.box(extents).apply_translation(at) for extents, at in boxes])


@pytest.mark.parametrize(
    ("extents", "axis", "elongated"),
    [((0.01, 0.012, 0.14), 2, True), ((0.01, 0.14, 0.012), 1, True), ((0.01, 0.03, 0.03), None, False)],
)
def test_rays_find_the_handle(extents: tuple[float, float, float], axis: int | None, elongated: bool) -> None:
    handle = find_handle(panel((extents, (0.03, -0.15, 0.1))))
    assert handle is not None
    assert handle.position == pytest.approx([0.035, -0.15, 0.1], abs=0.004)
    assert handle.protrusion == pytest.approx(0.035, abs=1e-3)
    assert handle.elongated == elongated
    if axis is not None:
        assert abs(handle.axis[axis]) == pytest.approx(1.0, abs=0.05)


def test_a_flat_panel_has_no_handle() -> None:
    assert find_handle(panel()) is None


def test_only_the_object_is_in_the_cloud() -> None:
    image = np.zeros((4, 4, 4), np.int16)
    image[1, 2] = [100, 200, -1000, 7]  # 10 cm right, 20 cm up, 1 m ahead; the object
    image[2, 2] = [0, 0, -500, 3]  # the robot
    pose = make_transform(yaw_matrix(np.pi / 2), [0.0, 0.0, 1.0])  # the camera looks along y
    points = observation.object_points(image, np.array([7, 8], np.int16), pose, np.full(3, -2.0), np.full(3, 2.0))
    assert points == pytest.approx(np.array([[0.1, 1.0, 1.2]]), abs=1e-5)
    assert len(observation.object_points(image, np.array([7], np.int16), pose, np.full(3, -2.0), np.zeros(3))) == 0


def test_a_large_picture_is_thinned_evenly() -> None:
    image = np.zeros((100, 100, 4), np.int16)
    image[..., 0], image[..., 2], image[..., 3] = np.arange(100)[:, None] * 10, -1000, 7
    points = observation.object_points(image, np.array([7], np.int16), np.eye(4), np.full(3, -9.0), np.full(3, 9.0))
    points = observation.thin_points(points, 2048)
    assert len(points) == 2048
    rows = np.bincount(np.rint(-points[:, 1] * 100).astype(int), minlength=100)
    assert rows.min() >= 20 and rows.max() <= 21


def test_finger_points_follow_the_gripper() -> None:
    tcp = panda_chain().pose(REST[None])[0]
    points = observation.finger_points(tcp, np.array([0.03, 0.01]), 40)
    across = (points - tcp[:3, 3]) @ tcp[:3, 1]
    left, right = across[:20], across[20:]
    assert left.min() == pytest.approx(0.03, abs=0.003) and right.max() == pytest.approx(-0.01, abs=0.003)
    cloud = observation.unify_cloud(np.ones((300, 3), np.float32), points, 100)
    assert cloud.shape == (100, 4) and cloud[:60, 3].max() == 0 and cloud[60:, 3].min() == 1


def test_the_scene_has_fewer_points_where_the_fingers_are() -> None:
    """Farthest points of the union: what a finger already stands for is not taken from the scene as well."""
    y, z = np.meshgrid(np.linspace(-0.2, 0.2, 60), np.linspace(-0.2, 0.2, 60))
    front = np.stack([np.zeros(3600), y.ravel(), z.ravel()], axis=1).astype(np.float32)
    rng = np.random.default_rng(0)
    near = rng.uniform([0.002, -0.05, -0.05], [0.004, 0.05, 0.05], (64, 3)).astype(np.float32)

    def taken(fingers: np.ndarray) -> np.ndarray:
        cloud = observation.unify_cloud(front, fingers, 256)
        assert (cloud[:192, 3] == 0).all() and np.array_equal(cloud[192:, :3], fingers)
        assert len(np.unique(cloud[:192, :3], axis=0)) == 192 and (cloud[:192, 0] == 0).all()
        return (np.abs(cloud[:192, 1:3]) < 0.05).all(axis=1).sum()

    assert taken(near) < 0.8 * taken(near + np.float32([0.5, 0, 0]))


def test_orientation_does_not_jump_at_the_rest_pose() -> None:
    rest = panda_chain().pose(REST[None])[0]
    hands = [make_transform(yaw_matrix(yaw) @ rest[:3, :3], [0, 0, 0]) for yaw in (-0.02, 0.02)]
    quaternions = [observation.proprioception(hand, np.zeros(2), rest_quaternion())[3:7] for hand in hands]
    assert np.abs(quaternions[0] - quaternions[1]).max() < 0.05


def test_what_garbage_collection_leaves_out_is_freed_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    at_the_end: list[object] = []
    monkeypatch.setattr(atexit, "register", at_the_end.append)
    api._freeze_imports.__wrapped__()
    assert at_the_end == [gc.unfreeze] and gc.get_freeze_count() > 0
    gc.unfreeze()


def test_an_asset_stands_on_the_floor_in_the_middle_whatever_its_origin() -> None:
    one = asset((0.4, 0.4, 0.8)).model_copy(update={"box_min": (-0.1, -0.2, 0.1), "box_max": (0.3, 0.2, 0.9)})
    assert nominal_root(one, np.ones(3)) == pytest.approx([-0.1, 0, -0.1])
    assert nominal_root(one, np.array([1, 1, 2])) == pytest.approx([-0.1, 0, -0.2])
