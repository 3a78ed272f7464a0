"""Run times: the benchmark files that Snakemake wrote."""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.tables.rows import records
from roomkin.stages.tables.text import TextTable, number

JOB = ["stage", "name", "seconds", "cpu_seconds", "memory"]


def read_jobs(paths: Iterable[Path], root: Path) -> pd.DataFrame:
    """A row per benchmarked job, with `JOB`: wall and CPU seconds, peak resident memory in MiB (NaN: not measured).

    A file that is not there is left out: Snakemake writes none for a job that ran before benchmarks were asked for.

    Args:
        paths: .tsv files.
        root: a folder whose first level names the stage.

    Raises:
        InputError: a file is no benchmark file.
    """
    rows = []
    for path in sorted(path for path in set(paths) if path.is_file()):
        inner = path.relative_to(root)
        try:
            times = pd.read_csv(path, sep="\t", na_values=["-"])[["s", "cpu_time", "max_rss"]].astype(float)
        except (ValueError, KeyError) as error:
            what = f"is not a benchmark file of Snakemake ({error})."
            raise InputError(path, what, "delete it and run its rule again", code="E-BENCHMARK") from None
        rows += [(inner.parts[0], str(inner.with_suffix("")), *line) for line in times.itertuples(index=False)]
    return pd.DataFrame(rows, columns=JOB)


def by_stage(jobs: pd.DataFrame, stages: list[str]) -> pd.DataFrame:
    """Number of jobs, sums and peaks per stage, in the order of `stages`, others after them; the last row: total."""
    sums = {"seconds": ("seconds", "sum"), "cpu_seconds": ("cpu_seconds", "sum"), "memory": ("memory", "max")}
    found = jobs.groupby("stage").agg(jobs=("name", "size"), **sums)
    table = found.reindex([*(name for name in stages if name in found.index), *sorted(set(found.index) - set(stages))])
    table.loc["total"] = [len(jobs), jobs["seconds"].sum(), jobs["cpu_seconds"].sum(), jobs["memory"].max()]
    return table.astype({"jobs": int}).reset_index(names="stage")


def times_table(stages: pd.DataFrame) -> TextTable:
    """Time and memory by stage; `stages` as `by_stage` gives."""
    stages = stages.assign(memory=[f"{number(one, 0)} MiB" if one == one else "" for one in stages["memory"]])
    rows = [
        [row["stage"], str(row["jobs"]), duration(row["seconds"]), duration(row["cpu_seconds"]), row["memory"]]
        for row in records(stages)
    ]
    notes = [
        "Job time adds up jobs; on several cores some run at once. CPU time is sampled, misses the children of short "
        "jobs and so is a lower bound."
    ]
    columns = ["Stage", "Jobs", "Job time", "CPU time", "Peak memory"]
    return TextTable("cost", "Time by stage.", columns, rows, notes=notes)


def longest_table(jobs: pd.DataFrame) -> TextTable:
    """The jobs that took longest, as many as fit a screen."""
    longest = jobs.sort_values(["seconds", "name"], ascending=[False, True]).head(10)
    rows = [[row["name"], duration(row["seconds"]), duration(row["cpu_seconds"])] for row in records(longest)]
    return TextTable("longest", "The longest jobs.", ["Job", "Job time", "CPU time"], rows)


def duration(seconds: float) -> str:
    """'42 s', '3 min 20 s' or '2 h 05 min'; empty for what was not measured."""
    if seconds != seconds:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    hours, left = divmod(minutes, 60)
    return f"{hours} h {left:02d} min" if hours else f"{minutes} min {rest:02d} s"
