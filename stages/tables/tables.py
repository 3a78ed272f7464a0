"""Verb `tables`: Tables 2 and 3 from the rows of `evaluation`."""

from pathlib import Path

import pandas as pd

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options, write_text
from stages.contracts.policies import Rollout, SceneScore
from stages.tables import claims, formatting, table2, table3
from stages.tables.claim_tables import claims_table, stability_table
from stages.tables.markup import Table, html, latex
from stages.tables.rows import published_policies, published_runs, published_scenes, read_rows

ONE_SCENE = ["scene", "variant", "rank"]
ONE_TEST = ["task", "training_set", "run", "seed", "checkpoint", "test_asset"]


def as_csv(table: pd.DataFrame) -> str:
    """A table as text, numbers with six digits."""
    return table.to_csv(index=False, lineterminator="\n", float_format="%.6g")


def _write(out: Path, name: str, table: pd.DataFrame, shown: list[Table]) -> None:
    write_text(out / f"{name}.csv", as_csv(table))
    write_text(out / f"{name}.html", html(shown, shown[0].caption))
    write_text(out / f"{name}.tex", latex(shown))


def run(
    *,
    out: Path,
    scores: tuple[Path, ...] = (),
    rollouts: tuple[Path, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write table2.{csv,html,tex}, table3.{csv,html,tex} and table3_{differences,claims,stability}.csv into `out`.

    Args:
        out: folder to write into.
        scores: scores.csv files of generated scenes.
        rollouts: rollouts.csv files of policies.
        published: folder with the paper's values, table2.csv and table3.csv.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    scene_rows = read_rows(SceneScore, scores, ONE_SCENE)
    episode_rows = read_rows(Rollout, rollouts, ONE_TEST)
    paper = published_policies(published)

    scenes = table2.build(scene_rows, published_scenes(published), settings)
    _write(out, "table2", scenes, [formatting.scenes_table(scenes, settings)])

    policies = table3.build(episode_rows, paper, settings)
    gains = table3.differences(episode_rows, settings)
    shown = [formatting.policies_table(policies, paper, settings)]
    runs = published_runs(published)
    answers, stable = claims.answer(episode_rows, runs, settings), claims.stability(policies, runs)
    shown += [claims_table(answers, settings)] if len(answers) else []
    shown += [stability_table(stable)] if len(stable) else []
    shown += [formatting.differences_table(gains, settings)] if len(gains) else []
    shown += [formatting.runs_table(policies)] if (policies["status"] == "run").any() else []
    _write(out, "table3", policies, shown)
    write_text(out / "table3_differences.csv", as_csv(gains))
    write_text(out / "table3_claims.csv", as_csv(answers))
    write_text(out / "table3_stability.csv", as_csv(stable))
