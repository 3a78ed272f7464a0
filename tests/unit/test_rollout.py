"""Rollouts: scheduling of episodes over environments, rows; on a toy task instead of the simulator."""

import csv
import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel

from roomkin.stages.config.evaluation import RolloutOptions
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, read_rows, write_json
from roomkin.stages.contracts.kinds import KINDS
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.policies import ChosenRuns, Rollout, TaskAssets
from roomkin.stages.evaluation import choose, merge, rollout, selection_rollout, vector_env
from roomkin.stages.evaluation.simulators import maniskill
from roomkin.stages.evaluation.states import Purpose, Start, initial_states, share_states, starts_of
from roomkin.stages.evaluation.vector_env import roll_out
from roomkin.stages.policies.base import save_weights
from roomkin.stages.tasks.api import Observation, StepResult
from roomkin.stages.tasks.observation import Sensing
from roomkin.stages.training.train import run as train
from tests.refusals import refused
from tests.toy_reach import Float, ToyReach, write_store
from tests.unit.demo_assets import an_asset
from tests.unit.tables_results import rollout as made_rollout
from tests.unit.tables_results import write_rows

UNSEEN = ("c_1", "c_2", "d", "e")  # three of the test split, one for validation


class ToyTask:
    """The toy behind the interface of `EnvWrapper`: success within 5 cm."""

    open_tasks = 0

    def __init__(self, max_steps: int = 20) -> None:
        self.max_steps, self.seeds, self.folders = max_steps, list[int](), list[Path]()
        self.env = self
        ToyTask.open_tasks += 1

    def turn_to(self, folder: Path, joint: str, size: tuple[float, float, float]) -> None:
        self.folders.append(folder)

    def reset(self, seed: int) -> Observation:
        self.toy, self.steps = ToyReach(seed), 0
        self.seeds.append(seed)
        return self.observe()

    def observe(self) -> Observation:
        cloud, proprio = self.toy.observe()
        return {"point_cloud": cloud, "proprio": proprio}

    def step(self, action: Float) -> StepResult:
        self.toy.step(action)
        self.steps += 1
        success = self.toy.distance < 0.05
        return StepResult(
            self.observe(), success, success, 1 - self.toy.distance, success or self.steps == self.max_steps
        )

    def moment(self) -> int:
        return self.steps

    def recording(self, moments: list[int]) -> list[int]:
        return list(moments)

    def close(self) -> None:
        ToyTask.open_tasks -= 1


class Expert:
    """Knows the goal; episodes with an odd seed stand still."""

    def __init__(self, tasks: list[ToyTask]) -> None:
        self.tasks, self.batches = tasks, list[list[int]]()

    def start_episode(self, env_id: int, seed: int) -> None:
        assert self.tasks[env_id].seeds[-1] == seed

    def get_action(self, env_ids: list[int], clouds: list[Float], proprio: list[Float]) -> Float:
        self.batches.append(list(env_ids))
        idle = [self.tasks[i].seeds[-1] % 2 for i in env_ids]
        return np.stack([(1 - still) * self.tasks[i].toy.expert() for i, still in zip(env_ids, idle, strict=True)])


def test_every_state_once_in_order_and_stopped_at_success() -> None:
    tasks = [ToyTask() for _ in range(3)]
    expert = Expert(tasks)
    folders = {name: Path(name) for name in "ab"}
    starts = [(an_asset("ab"[seed % 2]), seed) for seed in range(100, 108)]
    episodes = roll_out(tasks, folders, expert, starts, record=True)  # type: ignore[arg-type]
    assert [(episode.asset, episode.seed) for episode in episodes] == starts
    assert [episode.success for episode in episodes] == [True, False] * 4
    assert all(episode.steps == 20 for episode in episodes if not episode.success)
    assert all(episode.steps < 20 for episode in episodes if episode.success)
    assert sorted(seed for task in tasks for seed in task.seeds) == list(range(100, 108))
    for task in tasks:
        assert task.folders == [Path("ab"[seed % 2]) for seed in task.seeds]  # each start with its own asset
    assert expert.batches[0] == [0, 1, 2]  # one forward pass for all
    assert all(episode.recording == list(range(episode.steps + 1)) for episode in episodes)  # the end included


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy that can reach, and the files of an experiment with two assets and four unseen ones."""
    folder = tmp_path_factory.mktemp("rollout")
    store = write_store(folder / "episodes.h5", 30)
    kwargs = {"pointnet_width": 16, "rnn_hidden": 16, "mlp": [16]}
    options = {"points": 64, "kwargs": kwargs, "steps": 20, "log_freq": 10, "num_checkpoints": 2, "wandb": "disabled"}
    train(episodes=(store,), per_store=30, options=json.dumps(options), out=folder / "policy", seed=4)
    about = {"category": "cabinet", "licence": "", "provenance": "", "checksum": ""}
    for name in ("a", "b", *UNSEEN):
        asset = Asset(id=name, box_min=(0, 0, 0), box_max=(1, 1, 1), mass=1, **about)
        write_json(folder / "models" / name / "asset.json", asset)
    write_part(folder / "library.json", folder / "models")
    roles = [an_asset("a", 0.0, role="twin"), an_asset("b", 7.25, role="cousin_2")]
    everything = [item.model_copy(update={"role": "all"}) for item in roles]
    about = {"task": "door", "scene": "room_1", "object": "cabinet_1", "encoder": "hog"}
    unseen = [an_asset(name, role="test", handle="knob", handle_length=0.03) for name in UNSEEN]
    splits = {"test_assets": unseen[:3], "validation_assets": [unseen[3].model_copy(update={"role": "validation"})]}
    plan = TaskAssets.model_validate(about | {"assets": roles, "all_assets": everything} | splits)
    write_json(folder / "task.json", plan)
    return folder


def evaluate(
    folder: Path,
    out: Path,
    trained_roles: tuple[str, ...] = ("twin",),
    selection: tuple[Path, ...] = (),
    films: tuple[str, ...] = (),
    **options: object,
) -> list[dict[str, str]]:
    settings = {"test_assets": ["twin", "cousin_2"], "rollouts": 5, "assets": 0} | options
    rollout.run(
        policy=folder / "policy",
        assets=folder / "task.json",
        library=folder / "library.json",
        target="my_door",
        policy_name="small",
        training_set="twin",
        trained_roles=trained_roles,
        run_name="lite",
        selection=selection,
        options=json.dumps(settings),
        films=films,
        out=out,
    )
    KINDS["rollouts"].check(out)
    return list(csv.DictReader(out.read_text().splitlines()))


Made = list[tuple[tuple[Any, ...], dict[str, Any]]]  # arguments of the environments


@pytest.fixture
def toy_simulator(monkeypatch: pytest.MonkeyPatch) -> Made:
    made: Made = []

    def toy(*args: Any, **given: Any) -> ToyTask:
        made.append((args, given))
        return ToyTask()

    monkeypatch.setattr(maniskill, "Environment", toy)
    return made


def test_a_condition_reaches_the_environments(folder: Path, tmp_path: Path, toy_simulator: Made) -> None:
    condition = {"depth_noise": True, "camera_error": (0.02, 3.0), "robot_init_noise": (0.1, 5.0), "vary_scale": True}
    evaluate(folder, tmp_path / "rollouts.csv", test_assets=["twin"], rollouts=1, **condition)
    (task, asset, joint, size, options), given = toy_simulator[0]
    assert (task, asset.name, joint, size) == ("door", "a", "j", (1.0, 1.0, 1.0))
    assert (options.base_xy, options.base_yaw) == (0.1, np.deg2rad(5.0))
    assert given["sensing"] == Sensing(True, (0.02, np.deg2rad(3.0))) and given["vary_scale"]


@pytest.mark.usefixtures("toy_simulator")
def test_rows_are_paired_and_repeatable(folder: Path, tmp_path: Path) -> None:
    rows = evaluate(folder, tmp_path / "a" / "rollouts.csv")
    assert [(row["test_asset"], row["episode"]) for row in rows] == [
        (role, str(i)) for role in ("twin", "cousin_2") for i in range(5)
    ]
    assert [row["initial_state"] for row in rows[:5]] == [row["initial_state"] for row in rows[5:]]
    assert min(int(row["initial_state"]) for row in rows) >= 2**31  # demonstrations stay below
    assert {row["seed"] for row in rows} == {"4"}
    assert {(row["target"], row["task"], row["policy"]) for row in rows} == {("my_door", "door", "small")}
    assert {row["feature_distance"] for row in rows[5:]} == {"7.25"}
    evaluate(folder, tmp_path / "b" / "rollouts.csv")
    assert (tmp_path / "a" / "rollouts.csv").read_bytes() == (tmp_path / "b" / "rollouts.csv").read_bytes()
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["rollouts.csv"], (
        "nothing is filmed unless it is asked for"
    )
    assert ToyTask.open_tasks <= 3  # those of the first test


@pytest.mark.usefixtures("toy_simulator")
@pytest.mark.parametrize("roles", [("twin", "cousin_2"), ("all",)])
def test_the_assets_of_the_training_take_turns(folder: Path, tmp_path: Path, roles: tuple[str, ...]) -> None:
    rows = evaluate(folder, tmp_path / "rollouts.csv", roles, test_assets=["trained"])
    assert [(row["test_asset"], row["asset"], row["episode"]) for row in rows] == [
        ("trained", "abab"[i % 2], str(i)) for i in range(5)
    ]
    states = [int(row["initial_state"]) for row in rows]
    assert states == sorted(set(states))
    assert {row["feature_distance"] for row in rows} == {"0.0", "7.25"}


@pytest.mark.usefixtures("toy_simulator")
def test_unseen_assets_are_a_test_role_of_their_own(folder: Path, tmp_path: Path) -> None:
    rows = evaluate(folder, tmp_path / "a.csv", assets=2, asset_rollouts=3)
    unseen = [row for row in rows if row["test_asset"] == "test"]
    assert [(row["asset"], row["family"], row["episode"]) for row in unseen] == [
        (name, name.split("_")[0], str(number)) for number, name in enumerate(["c_1"] * 3 + ["c_2"] * 3)
    ]
    assert {(row["handle"], row["handle_length"]) for row in unseen} == {("knob", "0.03")}
    assert len(rows) == 2 * 5 + 6 and len({row["initial_state"] for row in rows}) == 5 + 6  # states of their own
    other = evaluate(folder, tmp_path / "b.csv", assets=2, asset_rollouts=1, split="validation")
    assert [row["asset"] for row in other if row["test_asset"] == "validation"] == ["e"]


@pytest.mark.usefixtures("toy_simulator")
def test_too_short_a_split_is_said(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = evaluate(folder, tmp_path / "a.csv", assets=9, asset_rollouts=1)
    assert "evaluation: the test split has 3 assets of 9: all are used\n" in capsys.readouterr().err
    assert sum(row["test_asset"] == "test" for row in rows) == 3
    plan = read_json(TaskAssets, folder / "task.json").model_copy(update={"test_assets": []})
    assert set(starts_of(plan, folder, RolloutOptions(test_assets=["twin"]), (), 0)) == {"twin"}
    assert "the test split has 0 assets of 24: only roles are tested" in capsys.readouterr().err


def test_the_twin_may_be_tried_more_often_than_the_others(folder: Path) -> None:
    plan = read_json(TaskAssets, folder / "task.json")
    asked = RolloutOptions(test_assets=["twin", "cousin_2"], rollouts=3, twin_rollouts=5, assets=0)
    starts = starts_of(plan, folder, asked, (), 0)
    states = {role: [state for _, state in each] for role, each in starts.items()}
    assert len(states["twin"]) == 5 and states["cousin_2"] == states["twin"][:3]


def test_of_more_assets_than_states_some_are_left_out_evenly() -> None:
    many = [an_asset("a", float(number)) for number in range(7)]
    turns = share_states(many, [1, 2, 3])
    assert [(asset.distance, state) for asset, state in turns] == [(0.0, 1), (2.0, 2), (4.0, 3)]
    assert [asset.distance for asset, _ in share_states(many[:2], [1, 2, 3])] == [0.0, 1.0, 0.0]


@pytest.mark.parametrize("seed", [0, 7, 214_749, 20_261_122, 2**53 - 1])
def test_no_two_purposes_seeds_or_places_share_a_state(seed: int) -> None:
    kinds = [initial_states(purpose, seed, 100) for purpose in get_args(Purpose)]
    others = [initial_states("roles", seed + 1, 100), initial_states("test", seed, 100, place=1)]
    states = [state for each in (*kinds, *others) for state in each]
    assert len(set(states)) == len(states) == 600
    assert min(states) >= 2**31 and max(states) < 2**32  # demonstrations stay below
    assert initial_states("test", seed, 3) == initial_states("test", seed, 100)[:3]


@pytest.mark.usefixtures("toy_simulator")
def test_the_twin_is_tested_once_for_a_policy_that_was_trained_on_it(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tested: list[str] = []
    original = vector_env.PolicyVectorEnv.episodes

    def note(self: vector_env.PolicyVectorEnv, network: object, starts: list[Start], record: bool) -> object:
        tested.append(starts[0][0].role)
        return original(self, network, starts, record)  # type: ignore[arg-type]

    monkeypatch.setattr(vector_env.PolicyVectorEnv, "episodes", note)
    rows = evaluate(folder, tmp_path / "rollouts.csv", test_assets=["twin", "cousin_2", "trained"])
    assert tested == ["twin", "cousin_2"] and len(rows) == 15
    outcome = [[(row["initial_state"], row["steps"]) for row in rows if row["test_asset"] == role]
               for role in ("twin", "trained")]  # fmt: skip
    assert outcome[0] == outcome[1]


def select(folder: Path, out: Path, **options: object) -> list[dict[str, str]]:
    files = {"policy": folder / "policy", "assets": folder / "task.json", "library": folder / "library.json"}
    names = {"target": "my_door", "policy_name": "small", "training_set": "twin", "run_name": "lite"}
    settings = {"checkpoint": "rollouts", "selection_rollouts": 3} | options
    selection_rollout.run(**files, **names, options=json.dumps(settings), out=out)  # type: ignore[arg-type]
    KINDS["rollouts"].check(out)
    return list(csv.DictReader(out.read_text().splitlines()))


@pytest.mark.usefixtures("toy_simulator")
def test_a_trial_rolls_every_checkpoint_out_on_the_twin_from_states_of_its_own(folder: Path, tmp_path: Path) -> None:
    tried = select(folder, tmp_path / "trial.csv")
    steps = [f"checkpoints/step_{step}.safetensors" for step in (10, 20)]
    assert [(row["checkpoint"], row["test_asset"]) for row in tried] == [(n, "twin") for n in steps for _ in range(3)]
    assert len({row["initial_state"] for row in tried}) == 3
    assert {row["checkpoint"] for row in select(folder, tmp_path / "one.csv", checkpoint="last")} == {"last"}
    rows = evaluate(folder, tmp_path / "rollouts.csv", selection=(tmp_path / "trial.csv",), checkpoint="rollouts")
    assert not {row["initial_state"] for row in rows} & {row["initial_state"] for row in tried}
    assert len({row["checkpoint"] for row in rows}) == 1
    with refused("E-SELECTION-MISSING"):
        evaluate(folder, tmp_path / "rollouts.csv", checkpoint="rollouts")


def trial_of(path: Path, run: str, **successes: int) -> Path:
    """A trial of four episodes per checkpoint, of which so many succeed."""
    rows: list[BaseModel] = [
        made_rollout(number, number < count, run=run, checkpoint=checkpoint)
        for checkpoint, count in successes.items()
        for number in range(4)
    ]
    return write_rows(path / f"{run}.csv", rows)


def test_the_best_checkpoint_of_a_trial_is_the_later_of_equals(tmp_path: Path) -> None:
    rows = read_rows(Rollout, trial_of(tmp_path, "a", one=1, two=3, three=3, four=2))
    best = choose.best_checkpoint(rows)
    assert (best.run, best.checkpoint, best.successes, best.episodes) == ("a", "three", 3, 4)


def test_hyper_parameter_sets_are_chosen_by_their_best_checkpoint(tmp_path: Path) -> None:
    successes = {"a": {"x": 1, "y": 3}, "b": {"x": 2, "y": 2}, "c": {"x": 4, "y": 0}, "d": {"x": 3, "y": 1}}
    trials = tuple(trial_of(tmp_path, run, **each) for run, each in successes.items())
    choose.run(rollouts=trials, count=2, out=tmp_path / "chosen.json")
    chosen = read_json(ChosenRuns, tmp_path / "chosen.json")
    assert chosen.runs == ["c", "a"]  # of the equal a and d the one that was named first
    assert [(score.run, score.checkpoint, score.successes) for score in chosen.scores] == [
        ("a", "y", 3), ("b", "y", 2), ("c", "x", 4), ("d", "x", 3),
    ]  # fmt: skip
    KINDS["chosen"].check(tmp_path / "chosen.json")
    other = write_rows(tmp_path / "e.csv", [made_rollout(9, True, run="e")])
    with refused("E-SELECTION-MIXED"):
        choose.run(rollouts=(*trials, other), count=2, out=tmp_path / "none.json")
    assert not (tmp_path / "none.json").exists()


def test_rollouts_of_a_training_set_are_gathered_as_they_are(tmp_path: Path) -> None:
    paths = tuple(trial_of(tmp_path, run, best=count) for run, count in (("a", 1), ("b", 4)))
    merge.run(rollouts=paths, out=tmp_path / "all.csv")
    rows = [row for path in paths for row in read_rows(Rollout, path)]
    assert read_rows(Rollout, tmp_path / "all.csv") == rows and len(rows) == 8
    twin = write_rows(tmp_path / "c.csv", [made_rollout(training_set="cousins_4")])
    with refused("E-ROLLOUTS-MIXED"):
        merge.run(rollouts=(*paths, twin), out=tmp_path / "none.csv")


@pytest.mark.usefixtures("toy_simulator")
def test_bad_input_is_one_line(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no assets for the training set `all`"):
        plan = read_json(TaskAssets, folder / "task.json").model_copy(update={"all_assets": []})
        plan.assets_of("all", tmp_path)
    with pytest.raises(InputError, match="has no 'random_2': 1 x 0 assets were drawn for random_n"):
        plan.assets_of("random_2", tmp_path)
    with pytest.raises(InputError, match=r"has no role 'cousin_9' \(it has twin, cousin_2\)"):
        evaluate(folder, tmp_path / "rollouts.csv", test_assets=["cousin_9"])
    (tmp_path / "policy").mkdir()
    (tmp_path / "policy" / "config.json").write_text((folder / "policy" / "config.json").read_text())
    save_weights(tmp_path / "policy" / "policy.safetensors", {"x": __import__("torch").zeros(1)})
    for name in ("task.json", "library.json", "library.zip"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    with pytest.raises(InputError, match=r"policy\.safetensors: proprio_mean: has shape None"):
        evaluate(tmp_path, tmp_path / "rollouts.csv")
    assert not (tmp_path / "rollouts.csv").exists()
