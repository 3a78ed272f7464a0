"""Trainings that failed are told before any rollout: against a constant action, and against their siblings."""

from pathlib import Path

import pandas as pd
import pytest

from roomkin.plugins.claims import trainings
from roomkin.plugins.claims.trainings import collect, failed, failed_note, trainings_table
from roomkin.plugins.report import report
from roomkin.plugins.studies import results
from roomkin.stages.contracts.files import write_json
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from roomkin.stages.contracts.trained import TrainedPolicy, TrainingStore
from roomkin.stages.tables import policies
from roomkin.stages.tables.text import markdown
from tests.unit.tables_results import declared, rollout, rollouts, write_rows, write_run

ROOT = Path(__file__).resolve().parents[3]
PUBLISHED = ROOT / "report" / "published"
STUCK = "Door opening, lite, 4 cousins: seed 1 did not learn: validation loss -3.5, others -7.1"


def trained(
    root: Path, name: str, seed: int, loss: float | None, error: float = 0.2, target: str = "door", run: str = "lite",
    plateau: int = 200,
) -> Path:  # fmt: skip
    """A policy's config.json, whose constant action is off by 0.46."""
    path = root / "results" / "training" / target / run / name / run / f"seed_{seed}" / "config.json"
    known = {} if loss is None else {"best_error": error, "constant_error": 0.46, "plateau": plateau}
    write_json(
        path,
        TrainedPolicy(
            task=target, task_options=TaskConfig(), config=PolicyConfig(), seed=seed, data_digest="d", parameters=9,
            stores=[TrainingStore(file="f", asset="a", episodes=8, frames=99)], training_episodes=7,
            validation_episodes=loss is not None, best_step=2400, best_loss=loss, **known,
        ),
    )  # fmt: skip
    return path


def several(root: Path, losses: dict[str, list[float]], **more: object) -> list[Path]:
    """Trainings of some sets, one a loss, by seed."""
    return [trained(root, name, seed, loss, **more) for name, of in losses.items() for seed, loss in enumerate(of)]  # type: ignore[arg-type]


def outcomes(paths: list[Path]) -> list[str]:
    return [outcome for outcome in collect(paths)["outcome"] if outcome != trainings.LEARNED]


def test_a_policy_no_better_than_a_constant_action_did_not_learn_also_alone(tmp_path: Path) -> None:
    assert outcomes([trained(tmp_path, "twin", 0, -3.5, error=0.46)]) == ["did not learn"]
    assert outcomes([trained(tmp_path, "twin", 0, -3.5, error=0.45)]) == []


def test_a_policy_that_learned_late_is_told_and_no_measure_for_others(tmp_path: Path) -> None:
    paths = [trained(tmp_path, "twin", seed, -7.5, plateau=500) for seed in range(3)]
    paths += [trained(tmp_path, "twin", 3, -6.1, plateau=900)]
    table = collect(paths)
    assert failed(table) == ["Door opening, lite, twin: seed 3 learned late: validation loss -6.1, others -7.5"]
    assert table["others"].tolist() == [2, 2, 2, 3]


def test_a_loss_far_above_those_of_the_other_seeds_is_told(tmp_path: Path) -> None:
    paths = several(tmp_path, {"twin": [-8.1, -8.0, -8.2], "cousins_8": [-7.2, -5.1, -7.0, -7.4]})
    table = collect(paths)
    assert failed(table) == ["Door opening, lite, 8 cousins: seed 1 stayed behind: validation loss -5.1, others -7.2"]
    row = table[table["outcome"] == "stayed behind"].iloc[0]
    assert (row["training_set"], row["seed"], row["others"], row["others_loss"]) == ("cousins_8", 1, 3, -7.2)


EASY, HARD = [-8.1, -8.0, -8.2, -8.1, -8.0], [-6.6, -6.7, -6.5]
MEASURED = [-8.76, -8.62, -8.61, -8.20, -7.94, -7.31], [-7.09, -6.14, -7.63, -6.67, -6.92]


@pytest.mark.parametrize(
    ("losses", "told"),
    [
        ({"twin": EASY, "twin_randomised": EASY, "random_8": HARD}, []),  # a set may be harder
        ({"twin": [0.031, 0.052, 0.04, 0.036, 0.055]}, []),  # seeds of a diffusion policy differ much
        ({"twin": [0.031, 0.033, 0.032, 0.032, 0.055]}, ["stayed behind"]),
        (dict(zip(["twin", "cousins_8"], MEASURED, strict=True)), []),  # validation episodes: training losses are alike
        ({"twin": [-7.4, -7.2], "cousins_8": [-7.0, -4.9], "random_8": [-7.1, -6.9]}, ["stayed behind"]),
        ({"cousins_8": [-7.0, -4.9]}, []),  # which of the two is it?
        ({"twin": [-9.0, -8.0], "cousins_8": [-7.2, -7.1]}, []),
        ({"twin": [-8.0], "cousins_2": [-7.3], "cousins_8": [-7.2], "random_8": [-6.0]}, []),  # lone seeds
    ],
)
def test_a_loss_is_held_against_other_seeds_and_few_against_their_row_too(
    tmp_path: Path, losses: dict[str, list[float]], told: list[str]
) -> None:
    assert outcomes(several(tmp_path, losses)) == told


def test_those_that_did_not_learn_are_no_measure_for_others(tmp_path: Path) -> None:
    paths = several(tmp_path, {"twin": [-7.0, -7.1, -7.2]})
    paths += [trained(tmp_path, "twin", seed, -3.5, error=0.6) for seed in (3, 4, 5, 6)]
    paths += [trained(tmp_path, "twin", 7, -5.0)]
    assert outcomes(paths) == [*["did not learn"] * 4, "stayed behind"]


def test_losses_of_other_rows_and_methods_are_not_compared(tmp_path: Path) -> None:
    paths = several(tmp_path, {"twin": [-8.0, -8.1, -8.2, -8.1]})
    paths += several(tmp_path, {"twin": [0.031, 0.033, 0.032, 0.03]}, run="diffusion")
    paths += several(tmp_path, {"twin": [-5.0, -5.1, -5.2, -5.1]}, target="drawer")
    assert outcomes(paths) == [] and collect(paths)["others"].tolist() == [3] * 12


def test_without_validation_episodes_nothing_is_said(tmp_path: Path) -> None:
    paths = [trained(tmp_path, "twin", seed, None) for seed in range(4)]
    paths += several(tmp_path, {"cousins_8": [-7.0, -7.2, -7.1]})
    table = collect(paths)
    assert failed(table) == [] and table["outcome"].isna().tolist() == [True] * 4 + [False] * 3
    assert "| Door opening, lite | lite | twin | –<br>4 trainings | – | – |  |" in markdown(trainings_table(table))
    some = collect([*paths, trained(tmp_path, "twin", 4, -3.5, error=0.6)])
    assert "-3.50 to -3.50, 1 training | 0.60 | 0.46 | seed 4 did not learn" in markdown(trainings_table(some))


def stuck(root: Path) -> tuple[Path, ...]:
    paths = several(root, {"twin": [-8.0, -8.1], "cousins_4": [-7.0, -7.2, -7.1, -7.1]})
    return (*(path for path in paths if "cousins_4/lite/seed_1" not in str(path)),
            trained(root, "cousins_4", 1, -3.5, error=0.6))  # fmt: skip


def test_the_command_names_them_and_table_3_and_the_page_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    root = write_run(tmp_path)
    tables, episodes = root / "results/tables", write_rows(tmp_path / "rollouts.csv", rollouts())
    trainings.run(out=tables, policies=stuck(root))
    assert STUCK in capsys.readouterr().err
    assert {f"trainings.{suffix}" for suffix in ("csv", "html", "tex")} == {path.name for path in tables.iterdir()}
    policies.run(
        out=tables, figures=root / "results/figures", rollouts=(episodes,), more=("roomkin.plugins.claims.more",),
        trainings=(tables / "trainings.csv",), published=PUBLISHED, options='{"bootstrap_samples": 100}',
    )  # fmt: skip
    names = [f"{name}.{suffix}" for name in ("assets", "table3", "trainings") for suffix in ("csv", "html", "tex")]
    names += [f"table3_{what}.csv" for what in ("cells", "claims", "differences", "stability")]
    assert sorted([*names, "assets_by_handle.csv"]) == sorted(path.name for path in tables.iterdir())
    assert f"these failed, and count like all others: {STUCK}." in (tables / "table3.html").read_text()
    counted = pd.read_csv(tables / "table3.csv").query("training_set == 'cousins_4' and seed == 1")
    assert len(counted) == 5
    page = root / "results/report/index.html"
    report.run(out=page, published=PUBLISHED, **declared(root))  # type: ignore[arg-type]
    assert page.read_text().count(STUCK) >= 1 and "seed 1 did not learn" in page.read_text()


def test_a_healthy_run_has_the_table_and_no_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = several(tmp_path, {"twin": [-8.0, -8.1], "cousins_4": [-7.0, -7.2, -7.1, -7.1]})
    trainings.run(out=tmp_path, policies=tuple(paths))
    assert capsys.readouterr().err == "claims: 6 trainings, none failed\n"
    assert failed_note(trainings.read_trainings(tmp_path / "trainings.csv")) == []


def test_the_page_of_a_study_names_them(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(
        "experiment: {training_sets: [twin, cousins_4], seeds: [0, 1, 2, 3]}\ntables: {bootstrap_samples: 100}\n"
    )
    write_rows(tmp_path / "results/evaluation/policies/door/lite/twin/lite/seed_0/rollouts.csv", [rollout()])
    stuck(tmp_path)
    results.run(
        out=tmp_path / "out", configs=(ROOT / "config.yaml", tmp_path / "study.yaml"), published=PUBLISHED,
        results=tmp_path / "results", benchmarks=tmp_path / "benchmarks", machine="a test",
    )  # fmt: skip
    text = (tmp_path / "out/table3.md").read_text()
    assert f"count like all others: {STUCK}." in text
    assert "| Door opening, lite | lite | 4 cousins | -7.05<br>-7.10 to -3.50, 4 trainings |" in text
