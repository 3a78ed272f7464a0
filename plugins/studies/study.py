"""A study's page: how far the study has come, facts about the run, its tables in Markdown, what it cost."""

import os
from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from pathlib import Path

import pandas as pd

from roomkin.plugins.report.page.benchmarks import by_stage, read_jobs, times_table
from roomkin.stages.config.evaluation import USUAL
from roomkin.stages.config.model import Config
from roomkin.stages.config.targets import Cell
from roomkin.stages.config.training import policy_tables
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.policies import ChosenRuns
from roomkin.stages.tables.policy_tables import pool_of
from roomkin.stages.tables.rows import row_title, set_key, title
from roomkin.stages.tables.text import NOT_RUN, TextTable, markdown

FOLDED = 15  # rows; a longer table is closed until it is clicked


def cost(benchmarks: Path, stages: list[str]) -> TextTable:
    """Hours by stage."""
    return times_table(by_stage(read_jobs(benchmarks.glob("*/*.tsv"), benchmarks), stages))


def cpu() -> str:
    """Model and number of this machine's cores."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")
    return f"{os.cpu_count()} cores, {model}"


def facts(target: str, configs: tuple[Path, ...], commit: str, machine: str, about: Iterable[tuple[str, str]]) -> str:
    """The command, commit and machine of a study, and what else is known about it, as a list."""
    command = f"`snakemake --cores {os.cpu_count()} {target} --configfile {' '.join(map(str, configs))}`"
    known = [("Command", command), ("Commit", f"`{commit}`" if commit else ""), ("Machine", machine or cpu()), *about]
    return "\n".join(f"* {name}: {text}" for name, text in known if text) + "\n"


def fold_table(table: TextTable) -> str:
    """The table in Markdown; a long one is closed until it is clicked."""
    text = markdown(table)
    if len(table.rows) <= FOLDED:
        return text
    caption, rows, notes = text.split("\n\n", 2) if table.notes else (*text.rstrip("\n").split("\n\n"), "")
    summary = f'<details markdown="1">\n<summary>{len(table.rows)} rows</summary>'
    return "\n\n".join([caption, summary, rows, "</details>", notes])


def split_totals(table: TextTable) -> list[TextTable]:
    """Table 2 in two: the totals over all rooms, then room by room."""
    totals = [row for row in table.rows if row[0] == "total"]
    if not totals:
        return [table]
    rooms = [row for row in table.rows if row[0] != "total"]
    return [replace(table, rows=totals), replace(table, caption="Table 2, room by room.", rows=rooms, notes=[])]


KEYS = ["target", "policy", "condition", "training_set"]


def policy_file(results: Path, condition: str, cell: Cell, run: str, seed: int) -> Path:
    """The files of a policy's rollouts; `condition`: empty for the usual one."""
    folder = results / "evaluation" / (f"conditions/{condition}" if condition else "policies")
    return folder / Path(*cell) / f"{run}/seed_{seed}/rollouts.csv"


def list_counting_runs(config: Config, results: Path, cell: Cell) -> list[str]:
    """The policy configs that count: where selection rollouts chose, those that they chose."""
    path = results / "evaluation/selection" / Path(*cell) / "chosen.json"
    chose = config.experiment.needs_choice(cell.policy) and path.is_file()
    return read_json(ChosenRuns, path).runs if chose else config.experiment.plan(cell.policy).configs


def progress_table(config: Config, results: Path) -> TextTable:
    """A row per target (or pool), policy and condition, a column per training set: policies tested on all targets."""
    experiment = config.experiment
    pools = pool_of(policy_tables(config), experiment.targets)
    tasks = {pools[name]: experiment.task(name) for name in experiment.targets}
    found = [
        (pools[cell.target], cell.policy, condition or USUAL, cell.training_set, run, seed,
         policy_file(results, condition, cell, run, seed).is_file())
        for condition in ("", *config.evaluation.conditions)
        for cell in experiment.cells
        for run, seed in product(list_counting_runs(config, results, cell), experiment.plan(cell.policy).seeds)
    ]  # fmt: skip
    policies = pd.DataFrame(found, columns=[*KEYS, "run", "seed", "there"])
    whole = policies.groupby([*KEYS, "run", "seed"], sort=False)["there"].all()
    cells = whole.groupby(KEYS, sort=False).agg(done="sum", asked="size").reset_index()
    sets = sorted(cells["training_set"].unique(), key=set_key)
    rows, tested = [], {USUAL}
    for (target, policy, condition), part in cells.groupby(KEYS[:3], sort=False):
        if condition == USUAL or part["done"].any():
            tested.add(str(condition))
            texts = {
                name: f"{done} of {asked}" if done else NOT_RUN
                for name, done, asked in zip(part["training_set"], part["done"], part["asked"], strict=True)
            }
            name = row_title({"target": target, "task": tasks[str(target)], "policy": policy})
            rows.append([name, title(str(condition)), *(texts.get(each, "") for each in sets)])
    lacking = [title(name) for name in config.evaluation.conditions if name not in tested]
    return TextTable(
        "progress",
        "Policies that were rolled out, of those that are asked for.",
        ["Policy", "Condition", *map(title, sets)],
        rows,
        headers=2,
        notes=[f"Conditions without any rollout: {', '.join(lacking)}."] if lacking else [],
    )
