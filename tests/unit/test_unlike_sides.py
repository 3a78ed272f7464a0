"""Small pieces of geometry and bookkeeping, tried where sides, signs and orders differ, so that no mistake cancels."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch
from pydantic import ValidationError

from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.objects import Box, DepthError, Wall, distance_between
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.contracts.trained import check_policy
from roomkin.stages.extraction.contact import CONTACT_DISTANCE, DepthView
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.geometry.masks import measure_outline
from roomkin.stages.matching.candidates import lay_over
from roomkin.stages.policies.base import save_weights
from roomkin.stages.skills.open import OpenSkill
from roomkin.stages.tables.rows import tabulate_gains
from roomkin.stages.training.augment import Batch, widen_grips
from tests.unit.tables_results import rollout
from tests.unit.trained_policy import trained

K = np.array([[9.0, 0, 4], [0, 9.0, 4], [0, 0, 1]])
DOWN = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])  # camera ahead is floor down


def test_boxes_are_turned_by_no_more_than_half_a_quarter() -> None:
    Box(center=(0, 0, 1), size=(1, 2, 3), yaw=math.pi / 4)
    with pytest.raises(ValidationError, match="turn the box by quarters"):
        Box(center=(0, 0, 1), size=(1, 2, 3), yaw=0.9)


def test_a_turned_box_reaches_a_wall_by_both_of_its_sides() -> None:
    wall = Wall(id="wall_1", normal=(-1.0, 0.0, 0.0), offset=-5.0, points=10)
    box = Box(center=(3.0, 0.5, 1.0), size=(0.4, 2.0, 1.0), yaw=0.5)
    corner = max(x * math.cos(0.5) - y * math.sin(0.5) for x in (-0.2, 0.2) for y in (-1, 1))
    assert distance_between(box, wall) == pytest.approx(2 - corner)


@pytest.mark.parametrize(("beyond", "free"), [(0.02, 1.0), (0.2, 0.0)])
def test_what_hides_a_point_is_nearer_by_more_than_touch_and_error(beyond: float, free: float) -> None:
    error = DepthError(0.1, 0.0)
    view = DepthView(np.full((9, 9), 3.0, np.float32), K, error=error)
    point = np.array([[0.0, 0.0, 3.0 + CONTACT_DISTANCE + error.a - 0.05 + beyond]])
    assert view.share_free(point, np.zeros((9, 9), bool)) == free


def test_rays_meet_the_floor_below_and_no_level_above() -> None:
    frame = make_transform(DOWN, [0.5, 0.25, 2.0])
    view = DepthView(np.full((9, 9), 1.0, np.float32), K, frame=frame)
    (met,) = view.intersect_level(np.array([7]), np.array([4]), 0.5)
    np.testing.assert_allclose(met, [0.5 + 1.5 * 3 / 9, 0.25, 0.5])
    up = DepthView(np.full((9, 9), 1.0, np.float32), K, frame=make_transform(np.eye(3), [0, 0, 2.0]))
    assert np.isnan(up.intersect_level(np.array([7]), np.array([4]), 0.5)).all()


def test_an_end_without_depth_is_as_far_as_the_rest() -> None:
    """Something nearer lies to the right of a thing whose right end shows no depth: it may go on behind."""
    depth = np.full((40, 60), 3.0)
    mask = np.zeros((40, 60), bool)
    mask[10:30, 10:30] = True
    depth[mask] = 2.0
    depth[10:30, 24:30] = 0.0
    depth[:, 30:45] = 1.0
    found = measure_outline(mask, depth, np.ones_like(mask), lambda far: np.zeros_like(far))
    right, left = (int(np.argmax(found.directions @ side)) for side in ([1, 0], [-1, 0]))
    assert found.limit[right] > found.reach[right] + 10 and found.limit[left] == found.reach[left]


def test_an_outline_moves_no_edge_by_more_than_things_err() -> None:
    own, stated = np.array([[[0.0, 1.0], [0.0, 1.0]]]), np.array([[[0.02, 0.5], [-0.01, 1.01]]])
    moved = lay_over(own, stated)[0]
    assert moved[0, 0] == pytest.approx(0.02) and 0.5 < moved[0, 1] < 1
    np.testing.assert_allclose(moved[1], [-0.01, 1.01])


def test_gains_compare_all_policies_of_both_sides() -> None:
    """Two runs on one side and another one on the other: not the same policies."""
    rows = [
        rollout(episode, side == "new", training_set=side, seed=seed)
        for side, seeds in (("old", (0, 1)), ("new", (2,)))
        for seed in seeds
        for episode in range(2)
    ]
    table = pd.DataFrame([row.model_dump() for row in rows])
    found = tabulate_gains(table, ["task"], "training_set", "old", TablesConfig(bootstrap_samples=200))
    assert list(found["training_set"]) == ["new"]


def test_fingers_widen_along_the_hand_however_it_is_turned() -> None:
    """A hand turned about an odd axis: its own y is the way from finger to finger."""
    w, x, y, z = quaternion = torch.tensor([0.8, 0.2, 0.4, 0.4])
    across = torch.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    assert across.norm().item() == pytest.approx(1, abs=1e-6)
    about = np.array([0.2, 0.4, 0.4]) / 0.6  # the same by Rodrigues' formula
    angle, side = 2 * math.acos(0.8), np.array([0.0, 1.0, 0.0])
    turned = side * math.cos(angle) + np.cross(about, side) * math.sin(angle)
    turned += about * about.dot(side) * (1 - math.cos(angle))
    proprio = torch.zeros(1, 1, 9)
    proprio[..., 3:7], proprio[..., 7:] = quaternion, 0.006
    clouds = torch.zeros(1, 1, 2, 4)
    clouds[0, 0, :, :3] = torch.tensor(np.stack([0.02 * turned, -0.02 * turned]))
    clouds[..., 3] = 1.0
    batch = Batch(clouds, proprio, torch.zeros(1, 1, 7), torch.ones(1, 1))
    wide = widen_grips(batch, torch.Generator().manual_seed(0))
    more = float((wide.proprio - batch.proprio)[0, 0, 7])
    moved = (wide.clouds - batch.clouds)[0, 0, :, :3].numpy()
    assert more > 0.001
    np.testing.assert_allclose(moved, more * np.stack([turned, -turned]), atol=1e-5)


def test_a_policy_is_checked_with_its_weights(tmp_path: Path) -> None:
    folder = trained(tmp_path / "policy", PolicyConfig())
    check_policy(folder)
    check_policy(folder / "config.json")
    save_weights(folder / "last.safetensors", {"other": torch.zeros(3)})
    with pytest.raises(InputError, match=r"last\.safetensors"):
        check_policy(folder)


@pytest.mark.parametrize(("skills", "spare"), [(("open",), 0.0), (("open", "place"), 0.2)])
def test_what_follows_an_opening_gets_room(skills: tuple[str, ...], spare: float) -> None:
    skill = OpenSkill.__new__(OpenSkill)
    skill.task = SimpleNamespace(task=SimpleNamespace(skills=skills))  # type: ignore[assignment]
    assert skill.spare == spare
