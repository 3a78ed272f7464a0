"""Door and drawer in MuJoCo, for whoever wants to know whether a policy has learnt its simulator (docs/policies.md).

The same observation, actions, starts and success as in ManiSkill; physics, contacts, controller and depth are MuJoCo's.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import sapien
from numpy.typing import NDArray

from roomkin.plugins.mujoco import world
from roomkin.plugins.mujoco.world import ARM_JOINTS, FINGER_JOINTS, MODEL, ROBOT, DepthCamera, ModelFiles
from roomkin.stages.articulated.asset_folder import write_asset
from roomkin.stages.articulated.resizing import resize_model
from roomkin.stages.contracts import Asset, InputError, read_json
from roomkin.stages.geometry.frames import invert_transform
from roomkin.stages.planning.clearance import Surroundings
from roomkin.stages.simulation.kinematics import IK_DAMPING, LIMIT_MARGIN, MAX_JOINT_STEP, Array
from roomkin.stages.simulation.loading import load_asset, physics_scene
from roomkin.stages.simulation.observation import CAMERA_FROM_IMAGE
from roomkin.stages.simulation.robot import GRIPPER_CLOSED, GRIPPER_OPEN, REST, TCP, apply_delta, scale_action
from roomkin.stages.simulation.room import Moment, Recording
from roomkin.stages.simulation.target import Target, read_target
from roomkin.stages.tasks.api import EnvWrapper, Float
from roomkin.stages.tasks.base_placement import OFFICIAL_SUCCESS_FRACTION, find_success_opening, place_robot_and_asset
from roomkin.stages.tasks.initial_state import nominal_root, sample_initial_state, sample_scale
from roomkin.stages.tasks.observation import CameraRig, Observation, shoulder

SHOWN_ID = np.array([1], np.int16)  # entity id of what the cloud shows; everything else has 0


class MujocoTaskEnv(EnvWrapper):
    """A task on one asset, in MuJoCo. Its observations, actions, starts and success are those of `EnvWrapper`."""

    def __init__(self, *args: Any, **given: Any) -> None:
        """Args as of `EnvWrapper`; `room` and `randomise` have no effect.

        Raises:
            InputError: the task is neither door nor drawer.
        """
        super().__init__(*args, **given)
        if len(self.task.skills) > 1:
            what, fix = f"'mujoco' does not have the task {self.task.gym_id}.", "mujoco has doors and drawers"
            raise InputError("evaluation.simulator", what, fix, code="E-MUJOCO-TASK")
        self.rig = CameraRig([shoulder(self.options)], self.options, self.sensing)
        self._files = ModelFiles()
        self._known: tuple[Path, str] | None = None  # folder and joint of `target`
        self._camera: DepthCamera | None = None
        self._surroundings: Surroundings | None = None  # of `target`

    @property
    def env(self) -> Any:
        """The world that skills ask: the task itself answers."""
        return self

    def place(self, seed: int) -> None:
        """`reset` without looking."""
        setup = sample_initial_state(seed, self.options)
        scale = sample_scale(seed, self.options, self.options.scale_range if self.vary_scale else None)
        self._look_up(self._scale_model(self._nominal_folder(), scale))
        at = nominal_root(self._model_asset, np.ones(3))
        self.base, self.root = place_robot_and_asset(setup, self.target, at, self.options, self.sample_surroundings)
        self.rig.place({}, 0, seed)
        camera = self.base @ self.rig.pose("shoulder", 0)
        camera[:3, :3] = camera[:3, :3] @ CAMERA_FROM_IMAGE
        file, view, size = self._files.of(self.folder), self.options.camera_fov, self.options.camera_size
        self.model = world.build(file, self.base, self.root, camera, view, size)
        self.data = mujoco.MjData(self.model)
        self._scratch = mujoco.MjData(self.model)
        self._arm = [int(self.model.joint(ROBOT + name).qposadr[0]) for name in ARM_JOINTS]
        self._arm_dofs = [int(self.model.joint(ROBOT + name).dofadr[0]) for name in ARM_JOINTS]
        self._fingers = [int(self.model.joint(ROBOT + name).qposadr[0]) for name in FINGER_JOINTS]
        self.data.qpos[self._arm], self.data.qpos[self._fingers] = REST + setup.joints, GRIPPER_OPEN
        self.data.ctrl[:7], self.data.ctrl[7:] = REST + setup.joints, GRIPPER_OPEN
        mujoco.mj_forward(self.model, self.data)
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self.steps, self.success, self.official_success, self.opened = 0, False, False, 0.0

    def act(self, action: Float) -> None:
        """`step` without looking."""
        options = self.options
        given = np.asarray(action, dtype=float)[None]
        delta = scale_action(given[:, :6], options.position_step, options.rotation_step)
        start = self.joints()[:7]
        goal = self._reach(start, apply_delta(self.chain.pose(start[None]), delta)[0])
        closing = (np.clip(given[0, 6], -1, 1) + 1) / 2
        self.data.ctrl[:7] = goal
        self.data.ctrl[7:] = GRIPPER_CLOSED + closing * (GRIPPER_OPEN - GRIPPER_CLOSED)
        for _ in range(round(1 / (options.control_frequency * world.TIMESTEP))):
            mujoco.mj_step(self.model, self.data)
        self.steps += 1
        fractions = self._fractions()
        self.opened = fractions[self.joint]
        self.success = self.opened >= self.success_opening
        self.official_success |= max(fractions.values()) >= OFFICIAL_SUCCESS_FRACTION

    def observe(self) -> Observation:
        """The observation of the present state."""
        pictures = [self._picture()[None]] if self.render else []
        return self.rig.observation(self.joints(), pictures, SHOWN_ID, 0)

    @property
    def success_opening(self) -> float:
        """The fraction of the target joint's range that counts as open."""
        return find_success_opening(self.target, self.options)

    def joints(self) -> Array:
        """(9,) measured joints: seven of the arm, two of the fingers."""
        return np.array(self.data.qpos[[*self._arm, *self._fingers]])

    def reference(self) -> Array:
        """(4, 4) pose that the next action's delta is added to, in the base frame."""
        return np.asarray(self.chain.pose(self.joints()[None, :7])[0])

    def moment(self) -> Moment:
        """The poses of all bodies, for a film."""
        arm = dict(zip((*ARM_JOINTS, *FINGER_JOINTS), self.joints().tolist(), strict=True))
        return Moment(self.base, arm, self.root, self._positions(), [])

    def recording(self, moments: Sequence[Moment]) -> Recording:
        """Moments of this episode; the film is drawn by SAPIEN, of what happened in MuJoCo."""
        return Recording(self.folder, np.ones(3), self.target.side, moments, None, [])

    def close(self) -> None:
        """Free the simulator."""
        if self._camera is not None:
            self._camera.close()
        self._files.close()
        super().close()

    def sample_surroundings(self) -> Surroundings:
        """The object; its surfaces are sampled once."""
        self._surroundings = self._surroundings or Surroundings(self.target)
        return self._surroundings

    def obstacles(self) -> Array:
        """Nothing else stands about."""
        return np.zeros((0, 3))

    def base_from_asset(self) -> Array:
        """(4, 4) pose of the asset's root in the robot base frame."""
        return np.asarray(invert_transform(self.base) @ self.root)

    def _scale_model(self, folder: Path, scale: Array) -> Path:
        if (scale == 1).all():
            return folder
        out = self.sized / f"{folder.name}-{'-'.join(f'{value:.3f}' for value in scale)}"
        if not out.exists():
            asset = read_json(Asset, folder / "asset.json")
            size = np.array(asset.size) * scale
            robot, about = resize_model(folder, asset, size.tolist(), by_recipe=False)
            write_asset(robot, out, about)
        return out

    def _look_up(self, folder: Path) -> None:
        """Read the model and measure the target joint, if they are not those of the episode before."""
        if self._known != (folder, self.joint):
            self.folder, self._model_asset = folder, read_json(Asset, folder / "asset.json")
            self.target = self._read_target()
            self._surroundings = None
            self._known = folder, self.joint

    def _read_target(self) -> Target:
        scene = physics_scene()  # as long as its bodies
        body = load_asset(scene, self.folder, sapien.Pose(), True, "")
        return read_target(body, [joint.name for joint in body.active_joints].index(self.joint))

    def _positions(self) -> dict[str, float]:
        moving = [joint.name for joint in self._model_asset.joints]
        return {name: float(self.data.joint(f"{MODEL}{name}").qpos[0]) for name in moving}

    def _fractions(self) -> dict[str, float]:
        """The fraction of its range at which every joint is."""
        ranges = {name: self.model.joint(f"{MODEL}{name}").range for name in self._positions()}
        return {name: float((at - ranges[name][0]) / np.ptp(ranges[name])) for name, at in self._positions().items()}

    def _reach(self, start: Array, goal: Array) -> Array:
        """Joints (7,) near `start` that bring the hand towards `goal` (4, 4), base frame, by MuJoCo's Jacobian."""
        hand, data = self.base @ goal, self._scratch
        data.qpos[:] = self.data.qpos
        joints = start.copy()
        low, high = np.array([self.model.joint(ROBOT + name).range for name in ARM_JOINTS]).T
        site = self.model.site(ROBOT + TCP).id
        place, turn = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        error = np.zeros(6)
        wanted, found, away = np.zeros(4), np.zeros(4), np.zeros(4)
        mujoco.mju_mat2Quat(wanted, hand[:3, :3].ravel())
        for _ in range(20):
            data.qpos[self._arm] = joints
            mujoco.mj_kinematics(self.model, data)
            mujoco.mj_comPos(self.model, data)
            mujoco.mj_jacSite(self.model, data, place, turn, site)
            mujoco.mju_mat2Quat(found, data.site_xmat[site])
            mujoco.mju_negQuat(found, found)
            mujoco.mju_mulQuat(away, wanted, found)
            mujoco.mju_quat2Vel(error[3:], away, 1.0)
            error[:3] = hand[:3, 3] - data.site_xpos[site]
            jacobian = np.vstack([place, turn])[:, self._arm_dofs]
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + IK_DAMPING**2 * np.eye(6), error)
            joints = joints + step * min(1.0, MAX_JOINT_STEP / max(np.abs(step).max(), 1e-9))
            joints = np.clip(joints, low + LIMIT_MARGIN, high - LIMIT_MARGIN)
            if np.abs(step).max() < 1e-4:
                break
        return joints

    def _picture(self) -> NDArray[np.int16]:
        """(H, W, 4) position in the camera's frame in millimetres, and 1 where the cloud shows something."""
        if self._camera is None:
            self._camera = DepthCamera(self.model, world.CAMERA, self.options.camera_size)
        depth, ids = self._camera.take(self.data)
        shown = np.isin(ids, self._find_seen_geoms())
        half = (len(depth) - 1) / 2
        focal = len(depth) / 2 / np.tan(self.options.camera_fov / 2)
        v, u = np.mgrid[: len(depth), : len(depth)]
        points = np.stack([(u - half) / focal * depth, (half - v) / focal * depth, -depth], axis=-1)
        millimetres = np.clip(np.rint(1000 * points), -30_000, 30_000)
        return np.concatenate([millimetres, shown[..., None]], axis=-1).astype(np.int16)

    def _find_seen_geoms(self) -> list[int]:
        """Ids of what the cloud shows: the target link, or by `task.cloud` all links."""
        model = self.model
        if self.options.cloud == "object":
            links = [i for i in range(model.nbody) if model.body(i).name.startswith(MODEL)]
        else:
            links = [int(model.joint(f"{MODEL}{self.joint}").bodyid[0])]
        for i in range(model.nbody):  # parents come before their children
            if int(model.body(i).parentid[0]) in links and i not in links:
                links.append(i)
        return [i for i in range(model.ngeom) if int(model.geom(i).bodyid[0]) in links]
