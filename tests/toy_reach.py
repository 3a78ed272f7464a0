"""A toy task for policies: move the hand to an object that only the cloud shows, close the gripper there."""

import json
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.policy_config import TaskConfig

Float = NDArray[np.float32]
STEP = 0.05  # metres at action 1
OBJECT, FINGER = 72, 24


class ToyReach:
    """A hand that moves exactly as told, and an object: a small box somewhere in front of it."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.goal = self.random.uniform([0.4, -0.25, 0.2], [0.8, 0.25, 0.6]).astype(np.float32)
        self.hand = self.random.uniform([0.25, -0.1, 0.35], [0.35, 0.1, 0.5]).astype(np.float32)

    def observe(self) -> tuple[Float, Float]:
        """Cloud (96, 4) and proprioception (9,)."""
        box = self.goal + self.random.uniform(-0.03, 0.03, (OBJECT, 3))
        fingers = self.hand + self.random.uniform(-0.02, 0.02, (FINGER, 3))
        cloud = np.concatenate([np.c_[box, np.zeros(OBJECT)], np.c_[fingers, np.ones(FINGER)]]).astype(np.float32)
        return cloud, np.concatenate([self.hand, [1, 0, 0, 0, 0.04, 0.04]]).astype(np.float32)

    def expert(self) -> Float:
        """Straight to the goal; the gripper closes within 2 cm of it."""
        away = self.goal - self.hand
        action = np.zeros(7, np.float32)
        action[:3] = away / max(STEP, float(np.linalg.norm(away)))
        action[6] = 1.0 if np.linalg.norm(away) > 0.02 else -1.0
        return action

    def step(self, action: Float) -> None:
        """Move by the action."""
        self.hand = self.hand + STEP * np.clip(action[:3], -1, 1)

    @property
    def distance(self) -> float:
        """Metres from hand to object."""
        return float(np.linalg.norm(self.goal - self.hand))


def write_store(path: Path, episodes: int, first_seed: int = 0, steps: int = 14) -> Path:
    """An episode store of expert demonstrations in the layout of `demonstrations`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["task"] = "door"
        data.attrs["asset"] = "toy"
        data.attrs["task_options"] = json.dumps(TaskConfig(points=96).model_dump(mode="json"))
        for i in range(episodes):
            toy = ToyReach(first_seed + i)
            rows: list[tuple[Float, Float, Float]] = []
            for _ in range(steps):
                action = toy.expert()
                rows.append((*toy.observe(), action))
                toy.step(action)
            demo = data.create_group(f"demo_{i}")
            demo.attrs["asset"] = "toy"
            demo["obs/point_cloud"] = np.stack([row[0] for row in rows]).astype(np.float16)
            demo["obs/proprio"] = np.stack([row[1] for row in rows])
            demo["actions"] = np.stack([row[2] for row in rows])
    return path
