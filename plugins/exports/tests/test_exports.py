"""Demonstrations in formats of other people. Their readers run where `envs/readers.sh` has made their environment."""

import json
import os
import shutil
import subprocess
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from roomkin.plugins.exports.demonstrations import run
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.episode_store import read_episodes
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.attempt import RecordedEpisode, Recorder, write_episodes
from roomkin.stages.tasks.api import EnvWrapper
from tests.unit.test_demonstrations import experiment

ROOT = Path(__file__).resolve().parents[3]
READERS = ROOT / ".venv-readers" / "bin" / "python"
OPTIONS = TaskConfig(points=64)
LENGTHS = {"cab": (6, 4), "fridge": (5,)}

needs_readers = pytest.mark.skipif(not READERS.exists(), reason="no .venv-readers: bash envs/readers.sh makes it")


@pytest.fixture(scope="module")
def stores(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Stores of two assets, three episodes in all."""
    folder, random = tmp_path_factory.mktemp("stores"), np.random.default_rng(0)
    for asset, lengths in LENGTHS.items():
        episodes = []
        for seed, steps in enumerate(lengths):
            episode = RecordedEpisode(seed, asset, "door_0_joint", (0.4, 0.4, 0.7))
            for _ in range(steps):
                cloud, proprio, action = (random.uniform(-1, 1, n).astype(np.float32) for n in ((64, 4), 9, 7))
                proprio[3:7] /= np.linalg.norm(proprio[3:7])  # a turn
                episode.add({"point_cloud": cloud, "proprio": proprio}, action, action, 0.1)
            episodes.append(episode)
        write_episodes(folder / f"{asset}.h5", episodes, "door", "ACDC-OpenDoor-v1", asset, OPTIONS)
    return [folder / f"{asset}.h5" for asset in LENGTHS]


def read_by(script: str, *words: str, home: Path) -> Any:
    """What a script of tests/readers prints, run where this project is not."""
    environment = {"HF_HUB_OFFLINE": "1", "HF_HOME": str(home), "PATH": os.environ["PATH"], "HOME": str(home)}
    command = [str(READERS), "-I", str(ROOT / "tests" / "readers" / script), *words]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd="/", check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_robomimic_gets_all_stores_in_one_file(stores: list[Path], tmp_path: Path) -> None:
    for name in ("a", "b"):
        run(episodes=tuple(stores), out=tmp_path / name, format="robomimic")
    first, again = (tmp_path / name / "demonstrations.hdf5" for name in ("a", "b"))
    assert first.read_bytes() == again.read_bytes()
    merged = read_episodes(first).episodes
    apart = [episode for path in stores for episode in read_episodes(path).episodes]
    assert all(np.array_equal(a, b) for x, y in zip(merged, apart, strict=True) for a, b in zip(x, y, strict=True))
    with h5py.File(first) as file:
        assert file["data"].attrs["total"] == 15
        masks = {mask: [name.decode() for name in names] for mask, names in file["mask"].items()}
        assert file["data/demo_2/dones"][:].tolist() == [0, 0, 0, 0, 1]
    assert masks == {"train": ["demo_0", "demo_1", "demo_2"], "cab": ["demo_0", "demo_1"], "fridge": ["demo_2"]}


def test_every_tenth_episode_is_for_validation(stores: list[Path], tmp_path: Path) -> None:
    run(episodes=tuple(stores[:1] * 5), out=tmp_path, format="robomimic")
    with h5py.File(tmp_path / "demonstrations.hdf5") as file:
        assert file["mask/valid"][:].tolist() == [b"demo_9"] and len(file["mask/train"]) == 9


def test_a_store_of_another_command_needs_no_rewards(stores: list[Path], tmp_path: Path) -> None:
    (tmp_path / "theirs.h5").write_bytes(stores[0].read_bytes())
    with h5py.File(tmp_path / "theirs.h5", "a") as file:
        for name in ("rewards", "dones", "executed"):
            del file[f"data/demo_0/{name}"]
    run(episodes=(tmp_path / "theirs.h5",), out=tmp_path, format="robomimic")
    with h5py.File(tmp_path / "demonstrations.hdf5") as file:
        assert file["data/demo_0/rewards"][:].tolist() == [0, 0, 0, 0, 0, 1]


def test_a_broken_store_leaves_nothing(stores: list[Path], tmp_path: Path) -> None:
    (tmp_path / "broken.h5").write_bytes(stores[0].read_bytes()[:3000])
    with pytest.raises(InputError, match=r"broken\.h5"):
        run(episodes=(stores[1], tmp_path / "broken.h5"), out=tmp_path / "out", format="robomimic")
    assert not list((tmp_path / "out").iterdir())


@needs_readers
def test_robomimic_trains_a_step_on_it(stores: list[Path], tmp_path: Path) -> None:
    run(episodes=tuple(stores), out=tmp_path, format="robomimic")
    ours = read_episodes(stores[0]).episodes[0]
    files = (f"{tmp_path / 'demonstrations.hdf5'}:train", str(stores[0]))  # a store is read as it is, too
    both = read_by("robomimic_step.py", *files, home=tmp_path)
    assert [(found["demos"], found["sequences"]) for found in both] == [(3, 15), (2, 10)]
    for found in both:
        assert found["environment"] == "ACDC-OpenDoor-v1"
        assert found["first"]["point_cloud"] == pytest.approx(ours[0][0].flatten()[:4].astype(float).tolist())
        assert found["first"]["proprio"] == pytest.approx(ours[1][0][:4].tolist())
        assert found["actions"] == [4, 5, 7] and np.isfinite(found["loss"]) and found["moved"]


def test_lerobot_gets_frames_and_relational_metadata(stores: list[Path], tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is missing: make setup")
    for name in ("a", "b", "b"):  # once over what is there
        run(episodes=tuple(stores), out=tmp_path / name, format="lerobot")
    files = sorted(path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*") if path.is_file())
    assert [str(path) for path in files] == [
        "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet", "meta/info.json",
        "meta/stats.json", "meta/tasks.parquet",
    ]  # fmt: skip
    assert all((tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes() for path in files)
    info = json.loads((tmp_path / "a/meta/info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["total_frames"]) == ("v3.0", 3, 15)
    assert info["features"]["observation.point_cloud"]["shape"] == [64, 4] and info["fps"] == OPTIONS.control_frequency
    frames = parquet.read_table(tmp_path / "a/data/chunk-000/file-000.parquet")
    assert set(frames.column_names) == set(info["features"])
    assert frames["index"].to_pylist() == list(range(15))
    assert frames["episode_index"].to_pylist() == [0] * 6 + [1] * 4 + [2] * 5
    episodes = parquet.read_table(tmp_path / "a/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [(row["dataset_from_index"], row["dataset_to_index"], row["asset"]) for row in episodes] == [
        (0, 6, "cab"), (6, 10, "cab"), (10, 15, "fridge"),
    ]  # fmt: skip
    states = np.concatenate([episode[1] for path in stores for episode in read_episodes(path).episodes])
    stats = json.loads((tmp_path / "a/meta/stats.json").read_text())["observation.state"]
    assert stats["mean"] == pytest.approx(states.mean(0).tolist(), abs=1e-6)
    assert stats["std"] == pytest.approx(states.std(0).tolist(), abs=1e-6) and stats["count"] == [15]


@needs_readers
def test_lerobot_reads_it(stores: list[Path], tmp_path: Path) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is missing: make setup")
    run(episodes=tuple(stores), out=tmp_path / "out", format="lerobot")
    found = read_by("lerobot_read.py", str(tmp_path / "out"), str(OPTIONS.control_frequency), home=tmp_path)
    clouds, proprio, actions = read_episodes(stores[1]).episodes[0]
    assert (found["episodes"], found["frames"], found["part"]) == (3, 15, [1, 4])
    assert np.array(found["cloud"]) == pytest.approx(clouds[-1].astype(float))
    assert found["state"] == pytest.approx(proprio[-1].tolist()) and found["action"] == pytest.approx(actions[-1])
    assert found["padded"] == [False, True, True] and found["done"] and found["task"] == "open door"
    assert found["batch"] == [3, 64, 4] and len(found["mean"]) == 9


@pytest.fixture(scope="module")
def done_again(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Demonstrations on two assets, with noise, recovery and a drawn scale, exported for ManiSkill; made blind."""
    folder = tmp_path_factory.mktemp("maniskill")
    inputs = experiment(folder)
    world = TaskConfig(points=64)
    episodes = []
    for name, size in (("cab", (0.42, 0.45, 0.7)), ("narrow", (0.35, 0.4, 0.65))):
        task = EnvWrapper("door", folder / "models" / name, "door_0_joint", size, world, render=False)
        recorder = Recorder(task, DemonstrationsConfig(noise=0.004, recovery=1.0))
        found = (recorder.attempt(seed) for seed in range(20))
        episodes += islice((episode for episode, outcome in found if outcome.success), 2)
        task.close()
    write_episodes(folder / "episodes.h5", episodes, "door", "ACDC-OpenDoor-v1", "all", world)
    run(episodes=(folder / "episodes.h5",), out=folder / "out", format="maniskill", library=inputs["library"])
    return folder


def test_maniskill_gets_trajectories_of_its_own_kind(done_again: Path) -> None:
    stored = read_episodes(done_again / "episodes.h5").episodes
    for name, numbers in (("cab", (0, 1)), ("narrow", (2, 3))):
        about = json.loads((done_again / "out" / f"{name}.json").read_text())
        assert about["env_info"]["env_id"] == "roomkin.stages.tasks:ACDC-OpenDoor-v1" and "commit_info" not in about
        kwargs = about["env_info"]["env_kwargs"]
        assert kwargs["joint"] == "door_0_joint" and TaskConfig.model_validate(kwargs["options"]).points == 64
        assert [(each["success"], each["elapsed_steps"]) for each in about["episodes"]] == [
            (True, len(stored[number][2])) for number in numbers
        ]
        with h5py.File(done_again / "out" / f"{name}.h5") as file, h5py.File(done_again / "episodes.h5") as ours:
            for index, number in enumerate(numbers):
                executed = ours[f"data/demo_{number}/executed"][:]
                assert np.array_equal(file[f"traj_{index}/actions"], executed)
                assert len(file[f"traj_{index}/env_states/articulations/target_object"]) == len(executed) + 1


@pytest.mark.parametrize("states", [False, True])
def test_maniskill_replays_them_where_they_were_sent(
    done_again: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], states: bool
) -> None:
    """From seeds and actions alone, and from the states."""
    from mani_skill.trajectory.replay_trajectory import Args, main

    monkeypatch.chdir(shutil.copytree(done_again / "out", tmp_path / "sent"))
    for name in ("cab", "narrow"):
        kwargs = json.loads(Path(f"{name}.json").read_text())["env_info"]["env_kwargs"]
        assert Path(kwargs["asset_folder"]).parent == Path("assets")
    main(Args(traj_path="cab.h5", use_env_states=states))
    assert "2/2=100.00% demos saved" in capsys.readouterr().out


def test_maniskill_needs_the_library_and_what_was_executed(stores: list[Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--library"):
        run(episodes=tuple(stores), out=tmp_path, format="maniskill")
    (tmp_path / "theirs.h5").write_bytes(stores[0].read_bytes())
    with h5py.File(tmp_path / "theirs.h5", "a") as file:
        del file["data/demo_0/executed"]
    library = experiment(tmp_path / "library")["library"]
    with pytest.raises(InputError, match="has no executed"):
        run(episodes=(tmp_path / "theirs.h5",), out=tmp_path, format="maniskill", library=library)
    with pytest.raises(InputError, match="'fridge', which the library does not have"):
        run(episodes=(stores[1],), out=tmp_path, format="maniskill", library=library)
