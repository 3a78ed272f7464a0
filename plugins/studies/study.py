"""The parts of a study's page: facts about the run, its tables in Markdown, what it cost."""

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from roomkin.plugins.report.page.benchmarks import by_stage, read_jobs, times_table
from roomkin.stages.tables.markup import Table, markdown

FOLDED = 15  # rows; a longer table is closed until it is clicked


def cost(benchmarks: Path, stages: list[str]) -> Table:
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


def fold_table(table: Table) -> str:
    """The table in Markdown; a long one is closed until it is clicked."""
    text = markdown(table)
    if len(table.rows) <= FOLDED:
        return text
    caption, rows, notes = text.split("\n\n", 2) if table.notes else (*text.rstrip("\n").split("\n\n"), "")
    summary = f'<details markdown="1">\n<summary>{len(table.rows)} rows</summary>'
    return "\n\n".join([caption, summary, rows, "</details>", notes])


def split_totals(table: Table) -> list[Table]:
    """Table 2 in two: the totals over all rooms, then room by room."""
    totals = [row for row in table.rows if row[0] == "total"]
    if not totals:
        return [table]
    rooms = [row for row in table.rows if row[0] != "total"]
    return [replace(table, rows=totals), replace(table, caption="Table 2, room by room.", rows=rooms, notes=[])]
