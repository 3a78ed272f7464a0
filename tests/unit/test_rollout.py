"""Rollouts: scheduling of episodes over environments, rows, films; on a toy task instead of the simulator."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stages.contracts.errors import InputError
from stages.contracts.files import read_json, write_json
from stages.contracts.films import Films
from stages.contracts.kinds import KINDS
from stages.contracts.library import Library
from stages.contracts.policies import TaskAsset, TaskAssets
from stages.evaluation import rollout
from stages.evaluation.episodes import RolloutEpisode, roll_out
from stages.evaluation.film import pick, strip, take
from stages.policies.checkpoint import save_weights
from stages.tasks.api import Observation, StepResult
from stages.training.train import run as train
from tests.toy_reach import Float, ToyReach, write_store
from tests.unit.demo_assets import FRONT


class ToyTask:
    """The toy behind the interface of `TaskEnv`: success within 5 cm."""

    open_tasks = 0

    def __init__(self, max_steps: int = 20) -> None:
        self.max_steps, self.seeds = max_steps, list[int]()
        ToyTask.open_tasks += 1

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


class ToyStudio:
    """Films without a renderer: a grey that gets lighter."""

    def film(self, recording: list[int], frames: int) -> list[np.ndarray]:
        return [np.full((64, 80, 3), 10 * (frame + len(recording)) % 256, np.uint8) for frame in range(frames)]


class Expert:
    """Knows the goal; episodes with an odd seed stand still."""

    def __init__(self, tasks: list[ToyTask]) -> None:
        self.tasks, self.batches = tasks, list[list[int]]()

    def reset(self, slot: int, seed: int) -> None:
        assert self.tasks[slot].seeds[-1] == seed

    def act(self, slots: list[int], clouds: list[Float], proprio: list[Float]) -> Float:
        self.batches.append(list(slots))
        idle = [self.tasks[slot].seeds[-1] % 2 for slot in slots]
        return np.stack([(1 - still) * self.tasks[slot].toy.expert() for slot, still in zip(slots, idle, strict=True)])


def test_every_state_once_in_order_and_stopped_at_success() -> None:
    tasks = [ToyTask() for _ in range(3)]
    expert = Expert(tasks)
    episodes = roll_out(tasks, expert, range(100, 108), record=True)  # type: ignore[arg-type]
    assert [episode.seed for episode in episodes] == list(range(100, 108))
    assert [episode.success for episode in episodes] == [True, False] * 4
    assert all(episode.steps == 20 for episode in episodes if not episode.success)
    assert all(episode.steps < 20 for episode in episodes if episode.success)
    assert sorted(seed for task in tasks for seed in task.seeds) == list(range(100, 108))
    assert expert.batches[0] == [0, 1, 2]  # one forward pass for all
    assert all(episode.recording == list(range(episode.steps + 1)) for episode in episodes)  # the end included


def test_film_shows_a_success_and_a_failure() -> None:
    episodes = [RolloutEpisode(i, success=i in (2, 3), steps=9, recording=[i] if i else None) for i in range(6)]  # type: ignore[arg-type]
    assert [episode.seed for episode in pick(episodes)] == [2, 1]
    filmed = take(ToyStudio(), episodes, "twin", "cab", 4)  # type: ignore[arg-type]
    assert [(item.film.seed, item.film.file) for item in filmed] == [(1, "twin_failure.webp"), (2, "twin_success.webp")]
    assert strip(filmed[0]).shape == (24 + 128, 8 * 160, 3)
    assert [len(take(ToyStudio(), part, "twin", "cab", 4)) for part in (episodes[4:], [])] == [1, 0]  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy that can reach, and the files of an experiment with two assets."""
    folder = tmp_path_factory.mktemp("rollout")
    store = write_store(folder / "episodes.h5", 30)
    network = {"points": 64, "pointnet_width": 16, "rnn_hidden": 16, "mlp": [16], "flag_embedding": 8}
    options = {"network": network, "steps": 20, "log_every": 10, "keep": 2, "wandb": "disabled"}
    train(episodes=(store,), per_store=30, options=json.dumps(options), out=folder / "policy", seed=4)
    entries = [
        {"id": name, "category": "cabinet", "folder": name, "doors": 1, "drawers": 0, "checksum": ""} for name in "ab"
    ]
    write_json(folder / "library.json", Library.model_validate({"assets": entries}))
    roles = [
        TaskAsset(role=role, asset=name, category="cabinet", joint="door", size=(1, 1, 1), distance=distance, **FRONT)
        for role, name, distance in (("twin", "a", 0.0), ("cousin_2", "b", 7.25))
    ]
    everything = [item.model_copy(update={"role": "all"}) for item in roles]
    about = {"task": "door", "scene": "room_1", "object": "cabinet_1", "encoder": "hog"}
    plan = TaskAssets.model_validate(about | {"assets": roles, "all_assets": everything})
    write_json(folder / "task.json", plan)
    return folder


def evaluate(
    folder: Path, out: Path, trained_roles: tuple[str, ...] = ("twin",), **options: object
) -> list[dict[str, str]]:
    settings = {"test_assets": ["twin", "cousin_2"], "rollouts": 5, "envs": 2} | options
    rollout.run(
        policy=folder / "policy",
        assets=folder / "task.json",
        library=folder / "library.json",
        task_name="my_door",
        training_set="twin",
        trained_roles=trained_roles,
        run_name="lite",
        options=json.dumps(settings),
        out=out,
    )
    KINDS["rollouts"].check(out)
    return list(csv.DictReader(out.read_text().splitlines()))


@pytest.fixture
def toy_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rollout, "make_task", lambda *args, **options: ToyTask())
    monkeypatch.setattr(rollout, "Studio", ToyStudio)


@pytest.mark.usefixtures("toy_simulator")
def test_rows_are_paired_and_repeatable(folder: Path, tmp_path: Path) -> None:
    rows = evaluate(folder, tmp_path / "a" / "rollouts.csv")
    assert [(row["test_asset"], row["episode"]) for row in rows] == [
        (role, str(i)) for role in ("twin", "cousin_2") for i in range(5)
    ]
    assert [row["initial_state"] for row in rows[:5]] == [row["initial_state"] for row in rows[5:]]
    assert min(int(row["initial_state"]) for row in rows) >= 2**31  # demonstrations stay below
    assert {row["seed"] for row in rows} == {"4"} and {row["task"] for row in rows} == {"my_door"}
    assert {row["dino_distance"] for row in rows[5:]} == {"7.25"}
    evaluate(folder, tmp_path / "b" / "rollouts.csv")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["film.png", "films", "rollouts.csv"]
    films = read_json(Films, tmp_path / "a" / "films" / "films.json").films
    assert {film.role for film in films} == {"twin", "cousin_2"}
    with Image.open(tmp_path / "a" / "films" / films[0].file) as opened:
        assert opened.n_frames == 16 and opened.size == (80, 64)  # type: ignore[attr-defined]
    for name in ["film.png", "rollouts.csv", "films/films.json", *(f"films/{film.file}" for film in films)]:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
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
    assert {row["dino_distance"] for row in rows} == {"0.0", "7.25"}
    films = read_json(Films, tmp_path / "films" / "films.json").films
    assert {(film.role, film.asset) for film in films} == {("trained", "a")}


@pytest.mark.usefixtures("toy_simulator")
def test_the_twin_is_tested_once_for_a_policy_that_was_trained_on_it(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tested: list[str] = []
    original = rollout.Arena.test

    def note(arena: rollout.Arena, network: object, assets: list[TaskAsset], *rest: object) -> object:
        tested.append(assets[0].role)
        return original(arena, network, assets, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(rollout.Arena, "test", note)
    rows = evaluate(folder, tmp_path / "rollouts.csv", test_assets=["twin", "cousin_2", "trained"])
    assert tested == ["twin", "cousin_2"] and len(rows) == 15
    outcome = [[(row["initial_state"], row["steps"]) for row in rows if row["test_asset"] == role]
               for role in ("twin", "trained")]  # fmt: skip
    assert outcome[0] == outcome[1]


@pytest.mark.usefixtures("toy_simulator")
def test_checkpoint_chosen_by_rollouts_on_other_states(folder: Path, tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    tried: list[tuple[str, int]] = []
    original = rollout.Arena.episodes

    def count(
        arena: rollout.Arena, network: object, asset: TaskAsset, states: list[int], films: list | None = None
    ) -> object:
        tried.append((asset.role, states[0]))
        good = len(tried) == 1  # the first checkpoint wins
        if len(tried) <= 2:
            return [RolloutEpisode(state, success=good) for state in states]
        return original(arena, network, asset, states, films)  # type: ignore[arg-type]

    monkeypatch.setattr(rollout.Arena, "episodes", count)
    rows = evaluate(folder, tmp_path / "rollouts.csv", checkpoint="rollouts", selection_rollouts=3)
    assert {row["checkpoint"] for row in rows} == {"checkpoints/step_10.safetensors"}
    assert [role for role, _ in tried] == ["twin", "twin", "twin", "cousin_2"]
    assert tried[0][1] not in {int(row["initial_state"]) for row in rows}


@pytest.mark.usefixtures("toy_simulator")
def test_of_equally_good_checkpoints_the_later_one(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = rollout.Arena.episodes

    def alike(
        arena: rollout.Arena, network: object, asset: TaskAsset, states: list[int], films: object = None
    ) -> object:
        if len(states) == 3:  # those of the selection
            return [RolloutEpisode(state, success=state % 2 == 0) for state in states]
        return original(arena, network, asset, states, films)  # type: ignore[arg-type]

    monkeypatch.setattr(rollout.Arena, "episodes", alike)
    rows = evaluate(folder, tmp_path / "rollouts.csv", checkpoint="rollouts", selection_rollouts=3)
    assert {row["checkpoint"] for row in rows} == {"checkpoints/step_20.safetensors"}


@pytest.mark.usefixtures("toy_simulator")
def test_bad_input_is_one_line(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no assets for the training set `all`"):
        plan = read_json(TaskAssets, folder / "task.json").model_copy(update={"all_assets": []})
        plan.behind("all", tmp_path)
    with pytest.raises(InputError, match=r"has no role 'cousin_9' \(it has twin, cousin_2\)"):
        evaluate(folder, tmp_path / "rollouts.csv", test_assets=["cousin_9"])
    (tmp_path / "policy").mkdir()
    (tmp_path / "policy" / "config.json").write_text((folder / "policy" / "config.json").read_text())
    save_weights(tmp_path / "policy" / "policy.safetensors", {"x": __import__("torch").zeros(1)})
    for name in ("task.json", "library.json"):
        (tmp_path / name).write_text((folder / name).read_text())
    with pytest.raises(InputError, match=r"policy\.safetensors: proprio_mean: has shape None"):
        evaluate(tmp_path, tmp_path / "rollouts.csv")
    assert not (tmp_path / "rollouts.csv").exists()
