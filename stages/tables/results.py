"""Verb `results`: what a study found, as Markdown, CSV and figures to be committed; also while it is still running."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from stages.config.model import Config
from stages.contracts.files import read_json, write_text
from stages.contracts.policies import ChosenRuns, Rollout, TaskAssets
from stages.tables import claims, formatting, table3
from stages.tables.claim_tables import claims_table, stability_table
from stages.tables.drawing import look, save
from stages.tables.markup import Cell, Row, Table, markdown, number
from stages.tables.order import title
from stages.tables.policies import ONE_TEST
from stages.tables.policy_figures import figure4, figure9
from stages.tables.roles import roles_table
from stages.tables.rows import published_policies, published_runs, read_rows
from stages.tables.study import cost, facts, read_config
from stages.tables.writing import as_csv

STAGES = ["demonstrations", "training", "evaluation"]


def rollout_files(config: Config, results: Path) -> Iterator[Path]:
    """The rollouts of the study's policies, as far as they are there."""
    for task in config.experiment.tasks:
        plan = config.experiment.plan(task)
        for name in plan.training_sets:
            for run in plan.runs:
                for seed in plan.seeds:
                    path = results / f"evaluation/policies/{task}/{name}/{run}/seed_{seed}/rollouts.csv"
                    if path.is_file():
                        yield path


def asked(config: Config) -> pd.DataFrame:
    """The cells that the study is to fill, with the columns `table3.CELL`."""
    plans = {task: config.experiment.plan(task) for task in config.experiment.tasks}
    cells = [
        (task, asset, name)
        for task, plan in plans.items()
        for asset in config.evaluation.test_assets
        for name in plan.training_sets
    ]
    return pd.DataFrame(cells, columns=table3.CELL)


def _chosen(config: Config, results: Path) -> Table | None:
    """The trials of the hyper-parameter sets."""
    rows = []
    for task in config.experiment.tasks:
        for name in config.experiment.plan(task).training_sets:
            path = results / f"evaluation/trials/{task}/{name}/chosen.json"
            if config.experiment.chooses(task) and path.is_file():
                chosen = read_json(ChosenRuns, path)
                scores = ", ".join(f"{score.run} {score.successes}/{score.episodes}" for score in chosen.scores)
                rows.append(Row([Cell(title(task)), Cell(title(name)), Cell(", ".join(chosen.runs)), Cell(scores)]))
    columns = ["Task", "Training set", "Chosen", "Trials on the twin (best checkpoint of the first seed)"]
    return Table("chosen", "Hyper-parameter sets chosen by trials.", columns, rows, headers=2) if rows else None


def _told(config: Config, episodes: pd.DataFrame) -> list[tuple[str, str]]:
    """Seeds and numbers of rollouts."""
    plans = [config.experiment.plan(task) for task in config.experiment.tasks]
    seeds = sorted({seed for plan in plans for seed in plan.seeds})
    policy = ["task", "training_set", "run", "seed"]
    policies = episodes.groupby(policy).ngroups if len(episodes) else 0
    each = (
        episodes.groupby([*policy, "test_asset"]).size().groupby("task").max()
        if len(episodes)
        else pd.Series(dtype=int)
    )
    counts = [f"{count} ({'; '.join(title(task) for task in part.index)})" for count, part in each.groupby(each)]
    per_asset = (
        " and ".join(counts) if len(counts) > 1 else f"{config.evaluation.rollouts if each.empty else each.iloc[0]}"
    )
    rollouts = f"{len(episodes)} episodes of {policies} policies, {per_asset} per test asset"
    return [
        ("Seeds", f"{', '.join(map(str, seeds))} of training; {config.seed} of everything else"),
        ("Rollouts", rollouts),
    ]


def run(
    *,
    out: Path,
    configs: tuple[Path, ...] = (Path("config.yaml"),),
    results: Path = Path("results"),
    benchmarks: Path = Path("benchmarks"),
    published: Path = Path("report/published"),
    machine: str = "",
    commit: str = "",
) -> None:
    """Write table3.md, table3.csv, figure4 and figure9 into `out`: what is there of a study; the rest is `not run`.

    Args:
        out: folder to write into.
        configs: the config files of the study, later ones over earlier ones.
        results: folder that the study writes.
        benchmarks: folder of its benchmark files.
        published: folder with the paper's values.
        machine: what it ran on; this machine if left out.
        commit: of the code, to be named.
    """
    config = read_config(configs)
    options, paper, runs = config.tables, published_policies(published), published_runs(published)
    episodes = read_rows(Rollout, list(rollout_files(config, results)), ONE_TEST)
    cells = pd.concat([asked(config), paper[table3.CELL]]).drop_duplicates()
    table = table3.build(episodes, cells, options)
    pooled = table3.pool(table, options.confidence)
    shown = [formatting.policies_table(table, paper, options)]
    answers, stable = claims.answer(episodes, runs, options), claims.stability(table, runs)
    gains = table3.differences(episodes, options)
    shown += [claims_table(answers, options)] if len(answers) else []
    shown += [stability_table(stable)] if len(stable) else []
    shown += [formatting.differences_table(gains, options)] if len(gains) else []
    for task in config.experiment.tasks:
        path = results / f"experiment/{config.experiment.policy_variant}/{task}/assets.json"
        if path.is_file():
            roles = config.experiment.trained_roles(task)
            shown.append(
                roles_table(read_json(TaskAssets, path), roles, f"roles-{task}", f"{title(task)}: the assets.")
            )
    shown += [each for each in (_chosen(config, results), cost(benchmarks, STAGES)) if each]
    text = ["# Table 3", "", facts("all", configs, commit, machine, _told(config, episodes)), *map(markdown, shown)]
    text += [f"![{name}]({name}.svg)\n" for name in ("figure4", "figure9")]
    text.append("`table3.csv` has a row per task, test asset, training set, run and seed.\n")
    with look():
        save(figure4(pooled, paper), out, "figure4")
        save(figure9(pooled, paper), out, "figure9")
    write_text(out / "table3.csv", as_csv(table))
    write_text(out / "table3.md", "\n".join(text))
    done = table[table["status"] == "run"].drop_duplicates(table3.CELL)
    print(f"{len(done)} of {len(asked(config))} cells of the study, {number(len(episodes), 0)} episodes")
