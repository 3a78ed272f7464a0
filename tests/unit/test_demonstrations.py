"""`collect` from end to end, with the camera."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from roomkin.stages.articulated.urdf_writer import SURFACE_FRICTION
from roomkin.stages.config.training import RandomiseOptions
from roomkin.stages.contracts import Attempt, InputError, TaskAssets, write_json
from roomkin.stages.contracts.episode_store import read_attempts, read_episodes
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.collect import attempt_seeds, run
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.filmed import sample_factors
from tests.refusals import refused
from tests.unit.demo_assets import an_asset, cabinet

TASK = {"points": 128, "camera_size": 64}


def experiment(folder: Path, **changes: object) -> dict[str, Path]:
    """A library with two cabinets, and an experiment that has one of them as twin."""
    asset = cabinet(folder / "models" / "cab", **changes)
    cabinet(folder / "models" / "narrow", hinge=-1)
    write_part(folder / "library.json", folder / "models")
    twin = an_asset("cab", 0.0, role="twin", joint="door_0_joint", size=asset.size)
    near = twin.model_copy(update={"role": "all"})
    far = near.model_copy(update={"asset": "narrow", "family": "narrow", "size": (0.35, 0.4, 0.65), "distance": 1.0})
    chance = far.model_copy(update={"role": "random"})
    about = {"task": "door", "scene": "s", "object": "cab_1", "encoder": "patches"}
    plan = TaskAssets(**about, assets=[twin], all_assets=[near, far], random_assets=[chance])
    write_json(folder / "assets.json", plan)
    return {"assets": folder / "assets.json", "library": folder / "library.json"}


def test_collect_writes_successes_that_replay(tmp_path: Path) -> None:
    inputs = experiment(tmp_path)
    for name in ("a", "b"):
        run(
            **inputs,
            role="twin",
            episodes=2,
            out=tmp_path / name / "episodes.h5",
            options='{"noise": 0.004}',
            task_options=json.dumps(TASK),
            seed=3,
        )
    first = tmp_path / "a" / "episodes.h5"
    assert first.read_bytes() == (tmp_path / "b" / "episodes.h5").read_bytes()
    lines = (tmp_path / "a" / "attempts.jsonl").read_text().splitlines()
    ledger = [Attempt.model_validate_json(line) for line in lines]
    kept = [attempt for attempt in ledger if attempt.success]
    assert [attempt.episode for attempt in kept] == [0, 1] and all(attempt.opened > 0.5 for attempt in kept)
    with h5py.File(first) as file:
        data = file["data"]
        assert list(data) == ["demo_0", "demo_1"]
        options = TaskConfig.model_validate_json(data.attrs["task_options"])
        assert options == TaskConfig(**TASK)
        demo = data["demo_0"]
        steps = demo.attrs["num_samples"]
        assert demo.attrs["seed"] == kept[0].seed and steps == kept[0].steps
        cloud, proprio, actions, executed, joint = (
            demo[key][:] for key in ("obs/point_cloud", "obs/proprio", "actions", "executed", "joint")
        )
        assert demo["dones"][:].tolist() == demo["rewards"][:].tolist() == [0] * (steps - 1) + [1]
    assert cloud.shape == (steps, 128, 4) and cloud.dtype == np.float16
    assert proprio.shape == (steps, 9) and actions.shape == (steps, 7) and joint.shape == (steps,)
    assert np.abs(actions).max() <= 1.0 + 1e-6
    assert 0 < np.abs(executed - actions).max() < 1 and (executed[:, 3:] == actions[:, 3:]).all()
    assert joint[0] == 0.0 and joint[-1] > 0.5
    scene = cloud[0, cloud[0, :, 3] == 0, :3].astype(float)
    fingers = cloud[0, cloud[0, :, 3] == 1, :3].astype(float)
    assert np.linalg.norm(fingers.mean(axis=0) - proprio[0, :3]) < 0.03  # the fingers are at the hand
    assert 0.1 < np.ptp(scene[:, 1]) < 0.8 and np.median(scene[:, 0]) > 0.4  # the cabinet is in front of it

    # Evaluation sees the same first observation, from the options in the file.
    task = EnvWrapper("door", tmp_path / "models" / "cab", "door_0_joint", (0.4, 0.45, 0.7), options)
    again = task.reset(kept[0].seed)
    for action in executed:
        task.act(action)
    assert task.success and task.opened == pytest.approx(kept[0].opened, abs=1e-3), "what was executed replays"
    task.close()
    assert again["proprio"] == pytest.approx(proprio[0])
    assert again["point_cloud"] == pytest.approx(cloud[0].astype(np.float32), abs=2e-3)


def test_the_assets_of_the_role_all_take_turns_in_one_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, filmed = tmp_path / "all" / "episodes.h5", list[object]()
    films = SimpleNamespace(film_demonstrations=lambda *args: filmed.extend(args[1]))
    monkeypatch.setitem(sys.modules, "toy_films", films)
    run(**experiment(tmp_path), role="all", episodes=3, out=out, task_options=json.dumps(TASK), films=("toy_films",))
    store = read_episodes(out)
    assert len(filmed) == 1
    assert store.asset == "all" and store.assets == ["cab", "narrow", "cab"]
    assert [
        attempt.asset for attempt in read_attempts(out.parent / "attempts.jsonl") if attempt.success
    ] == store.assets
    with h5py.File(out) as file:
        first, second = (dict(file["data"][f"demo_{number}"].attrs) for number in (0, 1))
    assert first["joint"] == second["joint"] == "door_0_joint" and first["recovery"] in ("none", "push", "miss")
    assert second["size"].tolist() == [0.35, 0.4, 0.65]
    # hinged on opposite sides, the doors are opened by turning opposite ways
    turns = [np.arctan2(*proprio[-1, [1, 0]]) - np.arctan2(*proprio[0, [1, 0]]) for _, proprio, _ in store.episodes]
    assert turns[0] * turns[1] < 0 < turns[0] * turns[2]


def test_a_randomised_twin_is_another_one_in_every_attempt(tmp_path: Path) -> None:
    """Stretched farther than `scale_range`; what evaluation takes over is the same as for every other store."""
    out = tmp_path / "randomised" / "episodes.h5"
    files, world = experiment(tmp_path), TASK | {"scale_variants": 8}
    ranges = {"extents": [0.6, 0.7], "friction": [1.2, 1.3], "mass": [2.0, 2.0], "joint_friction": [1.0, 1.0]}
    options = {"randomise": ranges, "noise": 0.0, "recovery": 0.0}
    run(
        **files,
        role="twin_randomised",
        episodes=2,
        out=out,
        options=json.dumps(options),
        task_options=json.dumps(world),
    )
    store = read_episodes(out)
    assert store.asset == "cab" and store.task_options == TaskConfig(**world)
    with h5py.File(out) as file:
        assert RandomiseOptions.model_validate_json(file["data"].attrs["randomise"]).extents == (0.6, 0.7)
        seed = int(file["data/demo_0"].attrs["seed"])
    folder, joint = tmp_path / "models" / "cab", "door_0_joint"
    made = {"assets": folder, "joint": joint, "size": None, "options": TaskConfig(**world), "render": False}
    drawn = EnvWrapper("door", **made, randomise=RandomiseOptions(**ranges))
    plain = EnvWrapper("door", **made, vary_scale=False)
    for _ in range(2):  # nothing adds up from episode to episode
        drawn.place(seed)
        plain.place(seed)
        assert ((drawn.env.scales >= 0.6) & (drawn.env.scales <= 0.7)).all()
        weighs, weighed = (sum(link.mass for link in task.env.object._objs[0].links) for task in (drawn, plain))
        assert weighs == pytest.approx(2.0 * weighed * np.prod(drawn.env.scales[0]), rel=0.02)
        for task, low, high in ((drawn, 1.2, 1.3), (plain, 1.0, 1.0)):
            (friction,) = {
                round(shape.physical_material.static_friction / SURFACE_FRICTION, 4)
                for link in task.env.object._objs[0].links
                for shape in link.collision_shapes
            }
            assert low <= friction <= high
    for task in (drawn, plain):
        task.close()


def test_factors_follow_from_the_seed_and_half_is_as_likely_as_double() -> None:
    drawn = np.log2([sample_factors(seed, RandomiseOptions(mass=(0.5, 2.0))) for seed in range(400)])
    assert np.abs(drawn[:, 1]).max() <= 1.0 and abs(np.median(drawn[:, 1])) < 0.15 and drawn[:, 1].std() > 0.5
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 0.15
    assert sample_factors(3, RandomiseOptions()) == sample_factors(3, RandomiseOptions())


def test_an_asset_that_was_drawn_by_chance_has_a_store_of_its_own(tmp_path: Path) -> None:
    out = tmp_path / "random_1" / "episodes.h5"
    run(**experiment(tmp_path), role="random_1", episodes=1, out=out, task_options=json.dumps(TASK))
    assert read_episodes(out).assets == ["narrow"]
    wider = tmp_path / "wider" / "episodes.h5"
    run(**experiment(tmp_path), role="random_1_randomised", episodes=1, out=wider, task_options=json.dumps(TASK))
    assert read_episodes(wider).assets == ["narrow"]
    for path, randomised in ((out, False), (wider, True)):
        with h5py.File(path) as file:
            assert ("randomise" in file["data"].attrs) == randomised
    with pytest.raises(InputError, match="has no 'random_2': 1 x 1 assets were drawn"):
        run(**experiment(tmp_path), role="random_2", episodes=1, out=out)


def test_too_few_successes_are_one_line_and_no_file(tmp_path: Path) -> None:
    inputs = experiment(tmp_path, handle="none")
    out = tmp_path / "out" / "episodes.h5"
    with refused("E-DEMONSTRATIONS-FEW", "only 0 of 2", "(no_handle 6)"):
        run(**inputs, role="twin", episodes=2, out=out, task_options=json.dumps(TASK))
    ledger = (out.parent / "attempts.failed.jsonl").read_text().splitlines()
    assert [Attempt.model_validate_json(line).cause for line in ledger] == ["no_handle"] * 6
    assert [path.name for path in out.parent.iterdir()] == ["attempts.failed.jsonl"], "nothing half-made stays"
    with pytest.raises(InputError, match="it has twin"):
        run(**inputs, role="cousin_1", episodes=2, out=out)


def test_attempts_of_roles_differ_and_stay_below_those_of_evaluation() -> None:
    twin, cousin = (list(attempt_seeds(0, role, 50)) for role in ("twin", "cousin_1"))
    assert not set(twin) & set(cousin)
    assert max(twin + cousin) < 2**31


def test_a_heavier_door_is_as_much_harder_to_turn(tmp_path: Path) -> None:
    cabinet(tmp_path / "cab")
    made = {"assets": tmp_path / "cab", "joint": "door_0_joint", "size": None, "options": TaskConfig(**TASK)}
    still = dict.fromkeys(["extents", "friction", "joint_friction"], (1.0, 1.0))
    inertias = []
    for randomised in (None, RandomiseOptions(mass=(2.0, 2.0), **still)):
        task = EnvWrapper("door", **made, render=False, vary_scale=False, randomise=randomised)
        task.place(3)
        inertias.append(np.array([link.inertia for link in task.env.object._objs[0].links]))
        task.close()
    np.testing.assert_allclose(inertias[1], 2 * inertias[0], rtol=1e-4)
