"""Two methods are never averaged, and never judged as runs of one: in every table, page and figure."""

import re
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure

from roomkin.plugins.claims import claims
from roomkin.plugins.report import report
from roomkin.plugins.studies import conditions, results
from roomkin.stages.config.evaluation import PolicyAbout, PolicyTables, TablesConfig
from roomkin.stages.config.model import Config, load, with_defaults
from roomkin.stages.config.training import policy_tables
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.tables import policies
from roomkin.stages.tables.policy_tables import check_methods, join_published, kinds_of, policy_notes, read_pooled
from roomkin.stages.tables.rows import published_runs, target_title
from tests.refusals import refused
from tests.unit.tables_results import declared, rollout, write_rows, write_run

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "report" / "published"
MORE = ("roomkin.plugins.claims.more",)
OPTIONS = TablesConfig(bootstrap_samples=100)
SHORT = '{"bootstrap_samples": 100}'
OPENED = {"lite": (16, 11), "mine": (7, 4)}  # of 16 on the twin, of 16 unseen assets
MIXED = {23 / 32, 15 / 32}
IN_WORDS = re.compile(r"23/32|15/32|\b(72|47)( ±[^%]*)? (\\?)%|71\.9|46\.9")
CONFIG = """
experiment:
  targets: {door: {room: room_1, object: cabinet_1}}
  rooms: [room_1]
  policies: {lite: {}, lite_handle: null, mine: {}}
training: {configs: {lite: {}, mine: {kwargs: {pointnet_width: 32}}}}
evaluation: {conditions: {noisy: {depth_noise: true}}}
tables: {bootstrap_samples: 100}
"""


def rolled(name: str, run: str, **changes: Any) -> list[Rollout]:
    """A policy on the twin, and on unseen assets."""
    twin, unseen = OPENED[run]
    of = {"training_set": name, "policy": run, "run": run} | changes
    on_assets = [
        rollout(n, n < unseen, test_asset="test", asset=f"a_{n}", feature_distance=1.0 + n, **of) for n in range(16)
    ]
    return [*(rollout(n, n < twin, **of) for n in range(16)), *on_assets]


def frame(rows: list[Rollout]) -> pd.DataFrame:
    return pd.DataFrame([row.model_dump() for row in rows])


def both(**changes: Any) -> list[Rollout]:
    return [row for name in ("twin", "cousins_4") for run in OPENED for row in rolled(name, run, **changes)]


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[float]]:
    """Every number and text that a figure shows, of all figures that are saved meanwhile."""
    found: list[Any] = []
    save = Figure.savefig

    def savefig(figure: Figure, *args: Any, **flags: Any) -> None:
        for axes in figure.axes:
            found.extend(value for line in axes.lines for value in np.ravel(line.get_data()))
            found.extend(value for dots in axes.collections for value in np.ravel(dots.get_offsets()))
            found.extend(text.get_text() for text in axes.texts)
        save(figure, *args, **flags)

    monkeypatch.setattr(Figure, "savefig", savefig)
    yield found


def assert_unmixed(folder: Path, drawn: list[Any]) -> None:
    """No file below a folder, and no figure, holds the mean of both methods."""
    files = [path for path in folder.rglob("*") if path.suffix in (".csv", ".html", ".tex", ".md")]
    assert files
    for path in files:
        text = re.sub(r"base64,[\w+/=]*|paper \d+ ± \d+ ", "", path.read_text())
        assert not IN_WORDS.search(text), (path, IN_WORDS.search(text))
        if path.suffix == ".csv":
            numbers = pd.read_csv(StringIO(text)).select_dtypes("number").to_numpy().ravel()
            assert not any(np.isclose(numbers, mean).any() for mean in MIXED), path
    numbers = np.array([value for value in drawn if not isinstance(value, str)], float)
    assert len(numbers) and not any(np.isclose(numbers, 100 * mean).any() for mean in MIXED)
    assert not any(IN_WORDS.search(value) for value in drawn if isinstance(value, str))


@pytest.mark.parametrize("known", [True, False])
def test_no_table_page_or_figure_of_a_run_mixes_two_methods(tmp_path: Path, drawn: list[Any], known: bool) -> None:
    root = write_run(tmp_path / "run")
    out, rows = root / "results/tables", write_rows(tmp_path / "rollouts.csv", list(both()))
    options = policy_tables(load(yaml.safe_load(CONFIG))).model_dump_json() if known else SHORT
    policies.run(
        out=out, figures=root / "results/figures", rollouts=(rows,), more=MORE, published=PUBLISHED, options=options
    )
    there = write_rows(tmp_path / "conditions/noisy/door/rollouts.csv", list(both()))
    conditions.run(out=out, rollouts=(rows,), elsewhere=(there,), names=("noisy",), options=SHORT)
    if known:
        report.run(out=root / "results/report/index.html", published=PUBLISHED, options=options, **declared(root))  # type: ignore[arg-type]
    assert_unmixed(root / "results", drawn)
    found = pd.read_csv(out / "assets.csv").set_index(["policy", "training_set"])
    assert found["mean"].to_dict() == {
        ("lite", "twin"): 11 / 16, ("lite", "cousins_4"): 11 / 16,
        ("mine", "twin"): 4 / 16, ("mine", "cousins_4"): 4 / 16,
    }  # fmt: skip
    assert set(found["runs"]) == {1} and set(found["target"]) == {"door"}
    assert found.loc["mine", "network_difference"].tolist() == [-7 / 16, -7 / 16]  # the second minus the first
    for name in ("table3", "table3_cells", "table3_claims", "table3_stability", "assets_by_handle", "conditions"):
        assert set(pd.read_csv(out / f"{name}.csv")["policy"]) >= {"lite", "mine"}, name
    assert not known or {"16/16", "7/16"} <= set(drawn)  # the page's charts


def test_no_file_of_a_study_mixes_two_methods(tmp_path: Path, drawn: list[Any]) -> None:
    (tmp_path / "study.yaml").write_text(CONFIG)
    for folder in ("policies/door", "conditions/noisy/door"):
        for name in ("twin", "cousins_4"):
            for run in OPENED:
                path = tmp_path / f"results/evaluation/{folder}/{run}/{name}/{run}/seed_0/rollouts.csv"
                write_rows(path, list(rolled(name, run)))
    results.run(
        out=tmp_path / "out", configs=(ROOT / "config.yaml", tmp_path / "study.yaml"), published=PUBLISHED,
        results=tmp_path / "results", benchmarks=tmp_path / "benchmarks", machine="a test",
    )  # fmt: skip
    assert_unmixed(tmp_path / "out", drawn)
    text = (tmp_path / "out/table3.md").read_text()
    for words in (
        "| Door opening, mine | usual | 1 of 1 | 1 of 1 |",
        "32-wide network of the paper's kind (mine), minus 64-wide network of the paper's kind (lite)",
    ):
        assert words in text, words


def test_two_methods_are_not_the_two_runs_that_a_claim_needs() -> None:
    """One seed of each: opened by all policies of the cousins, by none of the twin."""
    rows = [
        rollout(n, name == "cousins_4", training_set=name, policy=run, run=run, test_asset="test", asset=f"a_{n}")
        for name in ("twin", "cousins_4") for run in OPENED for n in range(40)
    ]  # fmt: skip
    for policy in ({}, {"policy": "best"}):  # also where trials chose both
        once = frame([row.model_copy(update=policy) for row in rows])
        table = claims.answer(once, papers(once), OPTIONS)
        assert set(table["verdict"]) == {"cannot be said"} and set(table["runs"]) == {1}, policy
    again = frame([*rows, *(row.model_copy(update={"seed": 1}) for row in rows)])
    table = claims.answer(again, papers(again), OPTIONS).set_index(["policy", "claim"])
    assert table.loc[("lite", "unseen"), "verdict"] == table.loc[("mine", "unseen"), "verdict"] == "holds"


def papers(ours: pd.DataFrame, **known: Any) -> pd.DataFrame:
    """The paper's runs, beside ours."""
    return join_published(published_runs(PUBLISHED), ours, PolicyTables(**known))


def test_the_paper_stands_beside_the_first_policy_of_its_kind_alone() -> None:
    rows = [rollout(target="fridge", policy=name, **more) for name in ("flag", "a", "b") for more in ({}, {"seed": 1})]
    whole = rollout(target="whole", cloud="object")
    found = papers(frame([whole, *rows]), kinds={"flag": "handle flagged", "a": "mine"}, papers=["a"])
    assert set(found.loc[found["task"] == "door", ["target", "policy"]].itertuples(index=False, name=None)) == {
        ("fridge", "a")
    }
    alone = found[found["task"] != "door"]
    assert set(alone["policy"]) == {""} and (alone["target"] == alone["task"]).all()


def test_runs_that_trials_chose_are_pooled_and_said_to_be(tmp_path: Path) -> None:
    best = PolicyAbout(configs=["lite", "mine", "third"], best=2, targets=["door"])
    options = PolicyTables(bootstrap_samples=100, policies={"best": best}, kinds={"best": "my network"})
    rows = list(both(policy="best"))
    check_methods(frame(rows), options)
    more = frame([*rows, *(row.model_copy(update={"run": "third"}) for row in rolled("twin", "mine", policy="best"))])
    with refused("E-RUNS-MIXED", "lite and mine and third of door/best/twin"):
        check_methods(more, options)  # not all were chosen
    with refused("E-RUNS-MIXED", "lite and mine of door/best/"):
        check_methods(frame(rows), PolicyTables())
    path = write_rows(tmp_path / "rollouts.csv", rows)
    policies.run(out=tmp_path, rollouts=(path,), more=MORE, published=PUBLISHED, options=options.model_dump_json())
    told = "my network (best 2 of settings lite, mine, third)"
    for name in ("assets.html", "table3.html", "table3.tex"):
        assert told in (tmp_path / name).read_text(), name
    assert pd.read_csv(tmp_path / "assets.csv")["mean"].tolist() == [15 / 32, 15 / 32]


def test_two_checkpoints_of_a_policy_are_no_two_runs(tmp_path: Path) -> None:
    rows = [*rolled("twin", "lite"), *rolled("twin", "lite", checkpoint="last")]
    with refused("E-CHECKPOINTS-MIXED", "best and last of the policy door/lite/twin/lite/0"):
        read_pooled([write_rows(tmp_path / "rollouts.csv", rows)], PolicyTables())
    each_its_own = [*rows[:32], *rolled("twin", "lite", checkpoint="last", seed=1)]
    check_methods(frame(each_its_own), PolicyTables())


def config_of(text: str) -> Config:
    return load(with_defaults(yaml.safe_load(text)))


def test_trials_choose_among_policies_of_one_kind() -> None:
    text = """{training: {configs: {wide: {kwargs: {pointnet_width: 128}}}},
    experiment: {best_configs: 1, policies: {best: {configs: [lite, %s]}}}}"""
    found = policy_tables(config_of(text % "wide")).policies["best"]
    assert (found.configs, found.best) == (["lite", "wide"], 1)
    with refused(
        "E-CONFIG-CLASH", "experiment.policies.best.configs: lite and lite_handle are other kinds of policies"
    ):
        config_of(text % "lite_handle")


def test_what_policies_are_is_told_by_the_config_and_by_no_name() -> None:
    config = config_of("""
    plugins: [roomkin.plugins.diffusion]
    experiment:
      targets: {fridge_handle: {task: door, room: room_3, object: hanging_cabinet_1}}
      policies: {lite_handle: null, door_handle: {configs: [long]}, blind: {}, diffusion: {},
        best: {configs: [a, b, lite]}}
    training:
      configs: {long: {horizon: 16}, a: {steps: 9}, b: {steps: 8}, blind: {kwargs: {cloud: false}},
        diffusion: {policy: diffusion}}
    """)
    paper = "64-wide network of the paper's kind"
    assert kinds_of(policy_tables(config)) == {
        "lite": f"{paper} (lite)", "door_handle": f"{paper} (door_handle)", "blind": "no cloud (blind)",
        "diffusion": "diffusion", "best": f"{paper} (best 2 of settings a, b, lite)",
    }  # fmt: skip
    assert policy_tables(config).papers == ["lite", "door_handle", "best"]
    assert target_title("fridge_handle", "door") == "Door opening, fridge handle"


def test_what_policies_are_given_is_as_the_options_say() -> None:
    usual = (
        "Policies are given what a real robot would not have: the mask of the target, depth without noise and exact "
        "camera poses, and they start within 3 and 7 cm of their place before the true handle. Demonstrations and "
        "tests share the simulator."
    )
    assert policy_notes(policy_tables(Config())) == [usual]
    noisy = "{evaluation: {depth_noise: true, camera_error: [0.01, 2.0], simulator: mujoco,"
    noisy += " robot_init_noise: [0.15, 20.0]}}"
    (note,) = policy_notes(policy_tables(config_of(noisy)))
    assert "depth without noise" not in note and "exact camera poses" not in note and "share" not in note
    for words in (
        "the mask of the target, and they start within 15 cm and 20 degrees", "has the noise of a depth camera",
        "1 cm and 2 degrees off the pose that they assume", "tests in MuJoCo",
    ):  # fmt: skip
        assert words in note, words
    (one,) = policy_notes(policy_tables(config_of("{evaluation: {depth_noise: true}, task: {base_xy: 0.1}}")))
    assert "the mask of the target and exact camera poses, and they start within 10 and 7 cm" in one
    (unknown,) = policy_notes(PolicyTables())
    assert "without noise" not in unknown and "as the options of their rollouts say" in unknown


def test_the_swap_and_the_page_compare_two_policies_as_two() -> None:
    page = (ROOT / "docs/extending.md").read_text()
    (mine,) = re.findall(r"```yaml\n# mine.yaml\n(.*?)```", page, re.DOTALL)
    for text in (mine, (ROOT / "config/swaps/diffusion.yaml").read_text()):
        known = policy_tables(config_of(text)).policies
        assert {name: about.configs for name, about in known.items()} == {
            "lite": ["lite"], "lite_handle": ["lite_handle"], "diffusion": ["diffusion"],
        }  # fmt: skip
        assert not any(about.best for about in known.values())
