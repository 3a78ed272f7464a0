"""The target `conditions`: the same policies under each condition, nothing trained or demonstrated again."""

import re
from pathlib import Path

from tests.workflow.workspace import dry_run, make, planned

TWO = """
evaluation:
  conditions:
    mujoco: {simulator: mujoco, depth_noise: true}
    parked: {robot_init_noise: [0.15, 20]}
"""


def asked(folder: Path, text: str) -> tuple[str, ...]:
    """Config arguments of the default run plus `text`."""
    (folder / "mine.yaml").write_text(text)
    return ("--configfile", "config.yaml", "mine.yaml")


def test_every_policy_and_skill_is_met_under_every_condition_and_told_what_differs(tmp_path: Path) -> None:
    folder = make(tmp_path)
    usual = planned(dry_run(folder, "evaluation", *asked(folder, "{}")).stdout)
    done = dry_run(folder, "conditions", "-p", *asked(folder, TWO))
    jobs = planned(done.stdout)
    assert done.returncode == 0, done.stdout
    assert jobs["rollout_under"] == 2 * usual["rollout"] and jobs["skill_under"] == 2 * usual["skill"]
    assert jobs["train"] == usual["train"] and jobs["demonstrate"] == usual["demonstrate"]
    found = re.finditer(r".*evaluation rollout.*results/evaluation/conditions/(\w+)/.*", done.stdout)
    told = {line[1]: line[0] for line in found}
    assert '"simulator": "mujoco"' in told["mujoco"] and '"depth_noise": true' in told["mujoco"]
    assert '"simulator": "maniskill"' in told["parked"] and '"robot_init_noise": [0.15, 20.0]' in told["parked"]


def test_without_conditions_the_target_says_what_to_write(tmp_path: Path) -> None:
    folder = make(tmp_path)
    assert "conditions: is empty. Fix:" in dry_run(folder, "conditions", *asked(folder, "{}")).stdout


def test_mujoco_is_asked_for_the_tasks_that_it_has_alone(tmp_path: Path) -> None:
    folder = make(tmp_path)
    bowl = "experiment: {targets: {bowl: {task: put_away_bowl, room: room_3, object: kitchen_cabinet_1}}}\n"
    done = dry_run(folder, "conditions", *asked(folder, bowl + TWO))
    assert done.returncode == 0, done.stdout
    assert "conditions/parked/bowl/skill" in done.stdout and "conditions/mujoco/door/skill" in done.stdout
    assert "conditions/mujoco/bowl" not in done.stdout


def test_a_condition_that_is_not_named_is_made_by_no_rule(tmp_path: Path) -> None:
    folder = make(tmp_path)
    done = dry_run(folder, "results/evaluation/conditions/nowhere/door/skill/rollouts.csv", *asked(folder, TWO))
    assert "MissingRuleException" in done.stdout, done.stdout
