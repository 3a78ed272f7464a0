"""What a study found, while it is still running: cells that are there, cells that are not, and how it was made."""

import shutil
import tarfile
from pathlib import Path

import pandas as pd
import pytest
from PIL import Image

from roomkin.plugins.studies import results
from roomkin.stages.config.model import Config, load
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.policies import ChosenRuns, RunScore, TaskAssets
from tests.refusals import refused
from tests.unit.tables_results import over_assets, picture, rollout, score, write_rows, write_run

ROOT = Path(__file__).resolve().parents[3]
PUBLISHED = ROOT / "report" / "published"
STUDY = """
seed: 7
experiment:
  rooms: [room_1]
  targets: {door: {room: room_1, object: cabinet_1}}
  policies: {lite: {configs: [lite, lite_slow]}}
  training_sets: [twin, cousins_4, cousins_8]
  best_configs: 1
  seeds: [0, 3]
training: {configs: {lite_slow: {learning_rate: 0.001}}}
evaluation: {test_assets: [twin, cousin_2, trained], rollouts: 10}
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A study of which the twin's policies, one of `cousins_4`, and none of `cousins_8` are there."""
    root = write_run(tmp_path / "run")
    shutil.rmtree(root / "results/evaluation")
    (root / "study.yaml").write_text(STUDY)
    policies = [("twin", "lite", 0), ("twin", "lite", 3), ("cousins_4", "lite_slow", 0)]
    policies += [("twin", "old", 0), ("twin", "lite", 9), ("all", "lite", 0)]  # of another study: not asked for
    policies += [("twin", "lite_slow", 0)]  # not chosen
    for name, run, seed in policies:
        same = {"training_set": name, "run": run, "seed": seed}
        rows = [
            rollout(n, n < 8, official_success=n < 9, test_asset=asset, **same)
            for asset in ("twin", "cousin_2", "trained")
            for n in range(10)
        ]
        write_rows(root / f"results/evaluation/policies/door/lite/{name}/{run}/seed_{seed}/rollouts.csv", list(rows))
        if run == "lite" and name == "twin":
            unseen = [row for row in over_assets({("lite", "twin"): 0.1}, 6) if row.seed == seed]
            write_rows(
                root / f"results/evaluation/policies/door/lite/twin/lite/seed_{seed}/rollouts.csv", [*rows, *unseen]
            )
    write_rows(root / "results/evaluation/skill/door/rollouts.csv", list(over_assets({("skill", "skill"): 0.0}, 6)))
    scores = [
        RunScore(run=run, checkpoint="best", successes=k, episodes=15) for run, k in (("lite", 9), ("lite_slow", 7))
    ]
    chosen = ChosenRuns(target="door", policy="lite", training_set="twin", runs=["lite"], scores=scores)
    folder = root / "results/evaluation/selection/door/lite/twin"
    folder.mkdir(parents=True)
    write_json(folder / "chosen.json", chosen)
    return root


def write(study: Path, out: Path, **flags: object) -> str:
    folders = {"results": study / "results", "benchmarks": study / "benchmarks", "published": PUBLISHED}
    results.run(out=out, configs=(ROOT / "config.yaml", study / "study.yaml"), **(folders | flags))  # type: ignore[arg-type]
    return (out / "table3.md").read_text()


def test_what_is_there_is_told_and_what_is_not_is_said_to_be_so(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = write(study, tmp_path / "out", machine="2 cores, a test", commit="abc1234")
    assert capsys.readouterr().out.splitlines()[-1] == f"Open {tmp_path / 'out/table3.md'}"
    table = pd.read_csv(tmp_path / "out/table3.csv")
    assert set(table["commit"]) == {"abc1234"}
    ran = table[table["status"] == "run"]
    keys = ["target", "policy", "test_asset", "training_set", "run", "seed"]
    assert len(ran) == len(ran.drop_duplicates(keys)) == 3 * 3
    assert (
        set(ran["run"]) == {"lite", "lite_slow"} and set(ran["seed"]) == {0, 3} and set(ran["cloud"]) == {"target_link"}
    )
    assert set(ran["episodes"]) == {10} and set(ran["successes"]) == {8} and set(ran["official_successes"]) == {9}
    lacking = table[(table["policy"] == "lite") & (table["status"] == "not run")]
    assert {("cousins_8", "trained"), ("cousins_8", "twin")} <= set(
        zip(lacking["training_set"], lacking["test_asset"], strict=True)
    )
    for words in (
        "Machine: 2 cores, a test", "Commit: `abc1234`", "Seeds: 0, 3 of training; 7 of everything else",
        "102 episodes of 3 policies, 10 per role", "6 of 3 families, 2 initial states each", "scripted skill: 100 %",
        "n = 1", "not run", "official 90 %, 80 steps", "*paper 90 ± 4 %*",
        "lite 9/15, lite_slow 7/15", "bar, hinge", "cannot be said", "1 run a side", "| total | ", "figure9.webp",
        "cloud of the target link", "0 of 2", "12 cm, at 50 % of the front", "true handle",
    ):  # fmt: skip
        assert words in text, words
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "table3.md", "table3.csv", "assets.csv", "assets_by_handle.csv",
        "figure4.webp", "figure9.webp",
    }  # fmt: skip


def test_how_far_the_study_has_come_is_told(study: Path, tmp_path: Path) -> None:
    met = study / "results/evaluation/conditions/mujoco/door/lite/twin/lite/seed_3/rollouts.csv"
    met.parent.mkdir(parents=True)
    shutil.copy(study / "results/evaluation/policies/door/lite/twin/lite/seed_3/rollouts.csv", met)
    others = "rollouts: 10, conditions: {mujoco: {simulator: mujoco}, own_size: {own_size: true}}"
    (study / "study.yaml").write_text(STUDY.replace("rollouts: 10", others))
    lines = write(study, tmp_path / "out").splitlines()
    start = next(n for n, line in enumerate(lines) if "that are asked for" in line)
    assert lines[start + 2 : start + 9] == [
        "| Policy | Condition | twin | 4 cousins | 8 cousins |", "|---|---|---|---|---|",
        "| Door opening, lite | usual | 2 of 2 | 1 of 4 | not run |",
        "| Door opening, lite_handle | usual | not run | not run | not run |",
        "| Door opening, lite | mujoco | 1 of 2 | not run | not run |",
        "", "Conditions without any rollout: own size.",
    ]  # fmt: skip
    assert "**Success under other conditions" in "\n".join(lines)


def test_a_task_that_was_rolled_out_less_often_is_said_to_be() -> None:
    tasks = (("door", "door", 5), ("bowl", "put_away_bowl", 2))
    rows = [rollout(n, target=target, task=task) for target, task, count in tasks for n in range(count)]
    episodes = pd.DataFrame([row.model_dump() for row in rows])
    told = dict(results._about_rollouts(Config(), episodes))
    assert told["Rollouts"] == "7 episodes of 2 policies, 2 (Putting away bowl) and 5 (Door opening) per role"


def test_what_was_shown_randomised_was_shown_in_wider_extents(study: Path) -> None:
    """An asset 1.4 times as large as the twin: between 0.6 and 1.5 times, and not between 0.75 and 1.25 times."""
    path = study / "results/experiment/b/door/assets.json"
    chosen = read_json(TaskAssets, path)
    twin = chosen.assets[0]
    width, height = twin.panel_size
    larger = {"panel_size": (1.4 * width, 1.4 * height), "handle_length": 1.4 * twin.handle_length}
    other = twin.model_copy(update={"role": "test", "asset": "large", "family": "large", **larger})
    write_json(path, chosen.model_copy(update={"test_assets": [other]}))
    sets = ("twin", "twin_randomised")
    rows = [rollout(asset="large", test_asset="test", training_set=name) for name in sets]
    config = load({
        "experiment": {"targets": {"door": {"room": "room_1", "object": "cabinet_1"}}},
        "task": {"scale_range": [0.75, 1.25]},
        "demonstrations": {"randomise": {"extents": [0.6, 1.5]}},
    })  # fmt: skip
    known = results._with_traits(config, study / "results", pd.DataFrame([row.model_dump() for row in rows]))
    assert dict(zip(known["training_set"], known["coverage"], strict=True)) == {"twin": 0.25, "twin_randomised": 1}


def test_nothing_but_the_study_is_looked_at_and_it_is_the_same_again(study: Path, tmp_path: Path) -> None:
    one, two = (write(study, tmp_path / name, machine="x") for name in ("one", "two"))
    assert one == two
    shutil.rmtree(study / "results")
    shutil.rmtree(study / "benchmarks")
    empty = write(study, tmp_path / "none", machine="x")
    assert "0 episodes of 0 policies" in empty and set(pd.read_csv(tmp_path / "none/table3.csv")["status"]) == {
        "not run"
    }


def test_configs_are_merged_as_the_workflow_merges_them(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("experiment: {seeds: [1], episodes: 8}")
    (tmp_path / "b.yaml").write_text("experiment: {seeds: [2]}")
    config: Config = results.read_files((tmp_path / "a.yaml", tmp_path / "b.yaml"))
    assert (config.experiment.seeds, config.experiment.episodes) == ([2], 8)
    (tmp_path / "c.yaml").write_text("[1")
    with refused("E-CONFIG-YAML"):
        results.read_files((tmp_path / "c.yaml",))


def test_a_study_of_table_2_tells_what_is_there_and_counts_whole_draws_alone(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(
        "experiment: {rooms: [room_1, room_2], targets: {door: null}, training_sets: [], variants: {b: {}, ours: {}}, "
        "protocols: {noise: {seeds: [1, 2], variants: [b]}, unknown: {unknown: true, variants: [ours]}}}"
    )
    scenes = {"room_1": {}, "room_2": {}, "room_1.noise.1": {"draw": 1}, "room_2.noise.1": {"draw": 1}}
    for scene, met in (scenes | {"room_1.noise.2": {"draw": 2}}).items():  # its room_2 is not there yet
        room, protocol = scene[:6], "noise" if met else ""
        path = tmp_path / f"results/evaluation/scenes/b/{scene}/scores.csv"
        write_rows(path, [score(room, 1, protocol=protocol, **met)])
    for variant in ("b", "ours"):
        picture(tmp_path / f"results/generation/{variant}/room_1/comparison.png", 700, 240, seed=4)
    results.run(
        out=tmp_path / "out", table=2, configs=(ROOT / "config.yaml", tmp_path / "study.yaml"),
        results=tmp_path / "results", benchmarks=tmp_path / "benchmarks", published=PUBLISHED,
        machine="a test", commit="abc1234", variants=("b",),
    )  # fmt: skip
    companion = pd.read_csv(tmp_path / "out/table2_robustness.csv").set_index(["protocol", "variant"])
    assert companion.loc[("noise", "b"), ["n_draws", "n_rooms", "n_objects"]].tolist() == [1, 2, 2]
    assert companion["n_draws"].isna()[("unknown", "ours")] and companion["n_draws"].isna()[("as shipped", "ours")]
    text = (tmp_path / "out/table2.md").read_text()
    with Image.open(tmp_path / "out/figure6.webp") as figure:
        assert figure.format == "WEBP" and figure.height > figure.width / 4
    for words in ("noise 1 2, unknown 0", "a test", "`abc1234`", "4 scored, 4 obj", "(figure6.webp)"):
        assert words in text, words


@pytest.mark.parametrize(
    "path", sorted((ROOT / "docs/results").rglob("*.csv")), ids=lambda path: f"{path.parent.name}/{path.name}"
)
def test_a_published_table_names_its_commit(path: Path) -> None:
    column = pd.read_csv(path, dtype=str, low_memory=False)["commit"]
    assert column.str.fullmatch("[0-9a-f]{7,40}").all() and column.nunique() <= 1


@pytest.mark.parametrize("path", sorted((ROOT / "docs/results").rglob("*.tar.xz")), ids=lambda path: str(path.name))
def test_a_published_archive_names_its_commit(path: Path) -> None:
    with tarfile.open(path) as archive:
        named = archive.extractfile("COMMIT")
        assert named is not None and len(named.read().strip()) >= 7
