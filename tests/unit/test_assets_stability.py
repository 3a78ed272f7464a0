"""Founders of every category, and its last relative, stand still: 100 physics steps on the floor, no renderer."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import CATEGORIES as RECORDS
from roomkin.plugins.furniture.library import make
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.simulation.loading import load_asset, physics_scene, root_pose
from tests.unit.physics import add_ground, position_of

CATEGORIES = sorted(AssetsConfig().counts)
STEPS, DRIFT, OPENING = 100, 0.01, 0.01


@pytest.mark.parametrize("category", CATEGORIES)
def test_nothing_explodes(category: str, tmp_path: Path) -> None:
    for index in {*range(RECORDS[category].templates), AssetsConfig().counts[category] - 1}:
        asset = make(category, index, 0, tmp_path)
        scene = physics_scene()
        add_ground(scene)
        fixed = asset.placement == "wall"
        start = root_pose(asset, (0.0, 0.0, asset.size[2] / 2 + 0.001), 0.3)
        body = load_asset(scene, tmp_path / asset.id, start, fixed, asset.id)
        for _ in range(STEPS):
            scene.step()
        moved = np.linalg.norm(position_of(body) - start.p)
        assert moved < DRIFT, f"{asset.id} moved {moved:.3f} m"
        pose = body.get_root_pose() if asset.joints else body.get_pose()
        assert abs(float(np.dot(pose.q, start.q))) > 0.9999, f"{asset.id} tipped"
        if asset.joints:
            assert np.abs(body.get_qpos()).max() < OPENING, f"{asset.id} opened by itself: {body.get_qpos()}"
            assert len(body.get_qpos()) == asset.doors + asset.drawers
