"""What `env.render()` shows, and that policies see nothing of it."""

from pathlib import Path

import gymnasium
import numpy as np
import sapien
import torch

import roomkin.stages.tasks  # noqa: F401
from roomkin.stages.simulation.film_renderer import _bounds
from roomkin.stages.simulation.loading import load_asset, physics_scene
from tests.unit.demo_assets import cabinet
from tests.unit.test_cameras import OPTIONS, folder
from tests.unit.test_stretching import SCALE, bounds

__all__ = ["folder"]


def test_rendering_for_people_changes_nothing_that_policies_see(folder: Path) -> None:
    """Room, floor and light stand in a scene of their own."""
    seen = []
    for rendered in (False, True):
        env = gymnasium.make("ACDC-OpenDoor-v1", asset_folder=folder, options=OPTIONS, render_mode="rgb_array")
        for episode in range(2):
            seen.append(env.reset(seed=episode)[0])
            for _ in range(3):
                if rendered:
                    env.render()
                seen.append(env.step(np.full(7, 0.2, np.float32))[0])
        if rendered:
            picture = env.render()[0].numpy()
            assert picture.shape == (360, 480, 3) and picture.dtype == np.uint8
            assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 60
        env.close()
    for plain, other in zip(seen[:8], seen[8:], strict=True):
        assert all(torch.equal(plain[part], other[part]) for part in ("point_cloud", "proprio"))


def test_a_film_knows_where_an_opened_stretched_door_is(tmp_path: Path) -> None:
    """SAPIEN's tight boxes of stretched hulls are wrong by decimetres once the door has turned."""
    cabinet(tmp_path / "door", handle="arch")
    scene = physics_scene()
    body = load_asset(scene, tmp_path / "door", sapien.Pose(), True, "door", SCALE)
    body.set_qpos(np.array([1.0], np.float32))
    for link in body.links:
        room = (_bounds([link]) - bounds(link)) * [[-1], [1]]
        assert (room > -1e-3).all() and (room < 0.02).all(), link.name  # PhysX boxes a turned hull by its own box
