"""Verb `results`: what a study found, as Markdown, CSV and figures to be committed; also while it is still running."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from stages.config.model import Config
from stages.contracts.files import read_json, write_text
from stages.contracts.policies import ChosenRuns, Rollout, TaskAssets
from stages.tables import table3
from stages.tables.assets import of_splits
from stages.tables.figures import write_figures
from stages.tables.markup import Cell, Row, Table, markdown, number
from stages.tables.order import SKILL, SPLITS, title
from stages.tables.policies import ONE_TEST, asset_tables, find, role_tables
from stages.tables.roles import lists_table, roles_table
from stages.tables.rows import published_policies, published_runs, read_rows
from stages.tables.study import cost, facts, read_config
from stages.tables.writing import as_csv

STAGES = ["demonstrations", "training", "evaluation"]


def rollout_files(config: Config, results: Path) -> Iterator[Path]:
    """The rollouts of the study's policies, and of the skill on the same assets, as far as they are there."""
    for task in config.experiment.tasks:
        skill = results / f"evaluation/skill/{task}/rollouts.csv"
        if skill.is_file():
            yield skill
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
    policies = episodes[episodes["training_set"] != SKILL]
    policy = ["task", "training_set", "run", "seed"]
    each = policies.groupby([*policy, "test_asset"]).size().groupby(["task", "test_asset"]).max()
    rollouts = f"{len(policies)} episodes of {policies.groupby(policy).ngroups} policies"
    roles = each[~each.index.isin(SPLITS, level="test_asset")].groupby("task").max()
    counts = [f"{count} ({'; '.join(map(title, part.index))})" for count, part in roles.groupby(roles)]
    if len(roles):
        rollouts += f", {' and '.join(counts) if len(counts) > 1 else roles.iloc[0]} per role"
    facts = [("Seeds", f"{', '.join(map(str, seeds))} of training; {config.seed} of everything else")]
    facts.append(("Rollouts", rollouts))
    for (group, split), part in of_splits(policies).groupby(["assets_of", "test_asset"]):
        assets = f"{part['asset'].nunique()} of {part['family'].nunique()} families"
        states = part.groupby("asset")["initial_state"].nunique().max()
        facts.append((f"{title(str(group))}, {title(str(split))}", f"{assets}, {states} initial states each"))
    return facts


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
    """Write table3.md, its tables as CSV, figure4 and figure9 into `out`: what is there of a study.

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
    found = find(episodes, cells, runs, options)
    shown = [*asset_tables(found, options), *role_tables(found, paper, options)]
    for task in config.experiment.tasks:
        path = results / f"experiment/{config.experiment.policy_variant}/{task}/assets.json"
        if path.is_file():
            chosen, roles = read_json(TaskAssets, path), config.experiment.trained_roles(task)
            shown.append(roles_table(chosen, roles, f"roles-{task}", f"{title(task)}: the assets."))
            shown += lists_table(chosen, f"lists-{task}", f"{title(task)}: sets of assets.")
    shown += [each for each in (_chosen(config, results), cost(benchmarks, STAGES)) if each]
    text = [
        "# Table 3: success over unseen assets, and by role",
        "",
        facts("all", configs, commit, machine, _told(config, episodes)),
        *map(markdown, shown),
    ]
    text += [f"![{name}]({name}.svg)\n" for name in ("figure4", "figure9")]
    text.append(
        "`table3.csv` has a row per task, role, training set, run and seed; `assets.csv` and `assets_by_handle.csv` "
        "hold success over unseen assets ([what the columns are](../tables.md)).\n"
    )
    write_figures(out, episodes, paper, options)
    write_text(out / "table3.csv", as_csv(found.runs))
    write_text(out / "assets.csv", as_csv(found.assets))
    write_text(out / "assets_by_handle.csv", as_csv(found.by_handle))
    write_text(out / "table3.md", "\n".join(text))
    done = found.runs[found.runs["status"] == "run"].drop_duplicates(table3.CELL)
    print(f"{len(done)} of {len(asked(config))} cells of the study, {number(len(episodes), 0)} episodes")
