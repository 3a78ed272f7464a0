"""The scripted skill on what policies are rolled out on; physics alone, no renderer."""

import json
from pathlib import Path

import pytest

from roomkin.plugins.scripted.skill import run
from roomkin.stages.config.evaluation import RolloutOptions
from roomkin.stages.contracts.files import read_json, read_rows, write_json
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.policies import Rollout, TaskAssets
from roomkin.stages.evaluation.states import starts_of
from tests.unit.demo_assets import an_asset, cabinet
from tests.unit.test_demonstrations import experiment

WORLD = json.dumps({"scale_variants": 4})


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Rollout]]:
    """The skill on a twin that opens, and on two unseen assets of which one has no handle."""
    folder = tmp_path_factory.mktemp("skill")
    files = experiment(folder)
    smooth = cabinet(folder / "models" / "smooth", handle="none")
    write_part(files["library"], folder / "models")
    plan = read_json(TaskAssets, files["assets"])
    unseen = [
        an_asset(name, role="test", joint="door_0_joint", size=size)
        for name, size in (("narrow", (0.35, 0.4, 0.65)), ("smooth", smooth.size))
    ]
    changed = {"test_assets": unseen, "all_assets": [], "random_assets": []}
    write_json(files["assets"], plan.model_copy(update=changed))
    options = {"test_assets": ["twin", "trained"], "rollouts": 2, "assets": 2, "asset_rollouts": 1}
    out = folder / "rollouts.csv"
    run(**files, target="my_door", out=out, options=json.dumps(options), task_options=WORLD, seed=3)
    return files["assets"], read_rows(Rollout, out)


def test_the_skill_has_rows_beside_the_policies(rows: tuple[Path, list[Rollout]]) -> None:
    _, found = rows
    assert [(row.test_asset, row.asset, row.success) for row in found] == [
        ("twin", "cab", True), ("twin", "cab", True), ("test", "narrow", True), ("test", "smooth", False),
    ]  # fmt: skip
    assert {(row.target, row.task, row.policy, row.training_set, row.run, row.checkpoint) for row in found} == {
        ("my_door", "door", "skill", "skill", "scripted", "none")
    }
    *opened, failed = found
    assert all(row.opened >= 0.5 and row.steps > 10 for row in opened)
    assert (failed.opened, failed.steps) == (0.0, 0)  # there is nothing to grasp


def test_the_skill_starts_where_policies_start(rows: tuple[Path, list[Rollout]]) -> None:
    path, found = rows
    settings = RolloutOptions(test_assets=["twin", "trained"], rollouts=2, assets=2, asset_rollouts=1)
    of_policies = starts_of(read_json(TaskAssets, path), path, settings, ("twin",), 3)
    for role in ("twin", "test"):
        states = [(row.asset, row.initial_state) for row in found if row.test_asset == role]
        assert states == [(asset.asset, state) for asset, state in of_policies[role]]
