"""Where a hand first closes, in the frame of the handle."""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from benchmarks.closings import Watched, draw, list_episodes
from stages.config.evaluation import RolloutOptions
from stages.contracts.policies import TaskAssets
from stages.contracts.task_options import TaskConfig
from stages.evaluation.states import starts_of
from stages.geometry.frames import rigid
from stages.tasks.api import TaskEnv
from tests.packages import needs
from tests.unit.demo_assets import an_asset, cabinet


def test_a_hand_is_noted_where_it_first_closes_wherever_the_joint_then_is(tmp_path: Path) -> None:
    cabinet(tmp_path / "door")
    task = TaskEnv("door", tmp_path / "door", "door_0_joint", None, TaskConfig(scale_variants=1), render=False)
    watched = Watched(task, {})
    watched.reset(5)
    still = np.array([0, 0, 0, 0, 0, 0, 1.0])
    watched.step(still)
    assert not watched.notes, "an open hand is not noted"
    watched.step(-still)
    ((key, note),) = watched.notes.items()
    target = task.env.target
    assert target.handle is not None and key == ("door", 5) and note["step"] == 1
    place = target.handle.position + np.array([note["out"], note["sideways"], note["up"]])
    where = task.env.base_from_asset() @ np.append(place, 1.0)
    assert where[:3] == pytest.approx(task.hand()[:3, 3], abs=0.01)
    assert note["high"] > 5 * note["wide"], "the bar of a door is upright"
    task.env.object.set_qpos(torch.tensor([[0.7]]))
    watched.step(-still)
    assert watched.notes[key] is note, "the first time alone"
    opened = watched.measure_grasp()
    assert abs(opened["out"] - note["out"]) > 0.05, "the handle has gone, the hand has stayed"
    task.close()


@needs("bowl")
def test_a_hand_that_is_to_pick_something_up_is_noted_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cabinet(tmp_path / "drawer", layout=[["drawer", "open", "open"]])
    options = TaskConfig(scale_variants=1)
    task = TaskEnv("put_away_bowl", tmp_path / "drawer", "drawer_0_joint", None, options, render=False)
    watched = Watched(task, {})
    watched.reset(5)
    close = np.array([0, 0, 0, 0, 0, 0, -1.0])
    watched.step(close)
    assert not watched.notes, "the hand is far from the bowl"
    item = task.env.movable()
    assert item is not None
    rim = item.base_from_object[:3, 3] + np.array([0.0, -0.05, 0.04])
    monkeypatch.setattr(task, "hand", lambda: rigid(np.eye(3), rim))
    watched.step(close)
    ((_, note),) = watched.notes.items()
    assert note["sideways"] == pytest.approx(-0.05, abs=0.005) and note["step"] == 1
    assert note["wide"] == pytest.approx(item.mesh.extents[1], rel=0.05)
    task.close()


def test_rollouts_on_unseen_assets_are_those_of_the_workflow() -> None:
    unseen = [an_asset(name, role="validation") for name in "ab"]
    plan = TaskAssets.model_construct(assets=[an_asset("c", role="twin")], validation_assets=unseen)
    given = argparse.Namespace(assets=Path("assets.json"), rollouts=2, unseen=2, unseen_rollouts=2, seed=3)
    settings = RolloutOptions(test_assets=["twin"], rollouts=2, split="validation", assets=2, asset_rollouts=2)
    expected = starts_of(plan, given.assets, settings, (), 3)
    assert {role: list_episodes(plan, role, given) for role in ("twin", "validation")} == expected
    assert [asset.asset for asset, _ in expected["validation"]] == ["a", "a", "b", "b"]


def test_a_panel_for_every_asset_and_set(tmp_path: Path) -> None:
    row = {"task": "door", "role": "twin", "wide": 0.01, "high": 0.2, "sideways": 0.01, "up": -0.02}
    rows = [row | {"training_set": name, "success": name == "twin"} for name in ("twin", "cousins_2")]
    pd.DataFrame([*rows, rows[0] | {"sideways": None, "up": None}]).to_csv(tmp_path / "table.csv", index=False)
    draw(argparse.Namespace(tables=[tmp_path / "table.csv"], out=tmp_path / "drawn.png"))
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")
