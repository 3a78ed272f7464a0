"""The manipulation task as demonstrations and evaluation use it: one environment, plain numpy in and out."""

import atexit
import gc
import importlib
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray

from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.contracts import Asset, InputError, read_json
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.plugins import load
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.robot import panda_chain
from roomkin.stages.simulation.room import TaskRoom
from roomkin.stages.tasks.observation import Observation, Sensing
from roomkin.stages.tasks.task import Task

if TYPE_CHECKING:
    from roomkin.stages.tasks.environment import OpenTaskEnv

Float = NDArray[np.float32]
Size = tuple[float, float, float]


@dataclass(frozen=True)
class StepResult:
    """Outcome of one control step. `done` is success or the end of `max_steps`; `official_success`: the official
    code's criterion was met at this step or before."""

    observation: Observation
    success: bool
    official_success: bool
    opened: float
    done: bool


class EnvWrapper:
    """A task on one asset: env = EnvWrapper(...); observation = env.reset(seed); result = env.step(action).

    Several may live in one process.

    Args:
        task: its name, e.g. 'door'; one of a package of yours by its module.
        assets: folder of the asset (with asset.json).
        joint: name of the joint to open.
        size: nominal closed box (x, y, z) in metres; None: as the asset is.
        options: the `task` section.
        render: False leaves out the camera (no point cloud in the observations, no pictures).
        cache: folder for the resized asset; default: a temporary one that `close` removes.
        vary_scale: False keeps the nominal size (official code leaves the evaluated asset's size alone).
        room: a generated scene about the asset.
        randomise: draw the asset's friction and mass with the episode, and its scale from this range.
        sensing: how the cameras differ from perfect ones.
    """

    def __init__(
        self,
        task: str,
        assets: Path,
        joint: str,
        size: Size | None,
        options: TaskConfig,
        render: bool = True,
        cache: Path | None = None,
        vary_scale: bool = True,
        room: TaskRoom | None = None,
        randomise: RandomiseOptions | None = None,
        sensing: Sensing | None = None,
    ) -> None:
        if options.sim_backend == "physx_cuda" and not torch.cuda.is_available():
            what, fix = "is physx_cuda, but torch finds no GPU.", "set it to physx_cpu"
            raise InputError("task.sim_backend", what, fix, code="E-DEVICE-GPU")
        self.task: Task = load("tasks", task)
        self.options, self.sensing = options, sensing
        self.turn_to(assets, joint, size)
        self.render, self.vary_scale, self.room, self.randomise = render, vary_scale, room, randomise
        self._temporary = None if cache else tempfile.TemporaryDirectory(prefix="acdc-sized-")
        self.sized = cache or Path(self._temporary.name)  # type: ignore[union-attr]
        self.max_steps = options.max_steps or self.task.horizon
        self.chain = panda_chain()
        self._env: OpenTaskEnv | None = None
        self._nominal: dict[tuple[Path, Size], Path] = {}  # folders of assets at their nominal sizes

    def turn_to(self, assets: Path, joint: str, size: Size | None) -> None:
        """Use another asset and joint from the next episode on; see `EnvWrapper`."""
        asset, part = read_json(Asset, assets / "asset.json"), self.task.part_type
        names = [candidate.name for candidate in asset.joints if candidate.part_type == part]
        if joint not in names:
            fix = f"its {part} joints: {names or 'none'}"
            raise ObjectError(assets, f"has no {part} joint {joint!r}.", fix, code="E-TASK-JOINT")
        self.assets, self.asset, self.joint, self.size = assets, asset.id, joint, size or asset.size

    @property
    def env(self) -> "OpenTaskEnv":
        """The ManiSkill environment; it exists after the first reset."""
        assert self._env is not None, "reset() first"
        return self._env

    def reset(self, seed: int) -> Observation:
        """Start the episode of `seed`, from which robot, object, scale, joint noise and camera all follow."""
        self.place(seed)
        return self.observe()

    def place(self, seed: int) -> None:
        """`reset` without an observation, which a skill does not need to plan."""
        folder = self._nominal_folder()
        if self._env is None:
            from roomkin.stages.simulation.rendering import render_backend

            module, _, name = self.task.environment.partition(":")
            environment = getattr(importlib.import_module(module), name)
            _freeze_imports()
            self._env = environment(
                task=self.task, asset_folder=folder, joint=self.joint, options=self.options, vary_scale=self.vary_scale,
                randomise=self.randomise, room=self.room, sensing=self.sensing, obs_mode="none", reward_mode="none",
                sim_backend=self.options.sim_backend, render_backend=render_backend() if self.render else "none",
            )  # fmt: skip
        self.env.asset_folder, self.env.joint_name = folder, self.joint
        self.env.reset(seed=seed)
        self.steps, self.success, self.official_success = 0, False, False
        self.opened = float(self.env.measure_opening()[0])

    def step(self, action: Float) -> StepResult:
        """Apply one action (7,) in [-1, 1]: translation, axis-angle (robot base axes), gripper (1 open, -1 closed)."""
        self.act(action)
        done = self.success or self.steps >= self.max_steps
        return StepResult(self.observe(), self.success, self.official_success, self.opened, done)

    def act(self, action: Float) -> None:
        """`step` without an observation."""
        _, _, _, _, info = self.env.step(np.asarray(action, np.float32))
        self.steps += 1
        self.success, self.opened = bool(info["success"][0]), float(info["opened"][0])
        self.official_success = bool(info["official_success"][0])

    def observe(self) -> Observation:
        """The observation of the present state."""
        return self.env.observe(render=self.render)[0]

    @property
    def success_opening(self) -> float:
        """The fraction of the target joint's range that counts as open."""
        return self.env.success_opening()

    def joints(self) -> Array:
        """(9,) measured joints: seven of the arm, two of the fingers."""
        joints: Array = self.env.agent.robot.get_qpos()[0].cpu().numpy().astype(np.float64)
        return joints

    def hand(self) -> Array:
        """(4, 4) measured pose of the tool center point in the base frame."""
        return np.asarray(self.chain.pose(self.joints()[None, :7])[0])

    def reference(self) -> Array:
        """(4, 4) pose that the next action's delta is added to, in the base frame."""
        controller = self.env.agent.controller.controllers["arm"]
        if hasattr(controller, "reference_pose"):
            return np.asarray(controller.reference_pose()[0])
        return np.asarray(controller._target_pose.sp.to_transformation_matrix(), dtype=float)

    def close(self) -> None:
        """Free the simulator."""
        if self._env is not None:
            self._env.close()
            self._env = None
        if self._temporary is not None:
            self._temporary.cleanup()

    def _nominal_folder(self) -> Path:
        from roomkin.stages.articulated.resizing import resize_asset

        key = (self.assets, self.size)
        if key not in self._nominal:
            self._nominal[key] = resize_asset(self.assets, self.size, self.sized)
        return self._nominal[key]


@cache
def _freeze_imports() -> None:
    """Keep what importing has left out of garbage collection, which every change of asset calls (0.2 s -> 0.02 s).

    It is collected when the process ends: else extensions (torch's Triton) report all their types as leaked.
    """
    gc.freeze()
    atexit.register(gc.unfreeze)
