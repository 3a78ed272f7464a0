"""What the pages about studies share: their configs, what they ran on, what they cost."""

import os
from collections.abc import Iterable
from functools import reduce
from pathlib import Path
from typing import Any

import yaml

from stages.config.model import Config, load, merged
from stages.contracts.errors import InputError
from stages.contracts.files import read_text
from stages.tables.markup import Cell, Row, Table
from stages.tables.page.benchmarks import by_stage, duration, read_jobs


def read_config(paths: tuple[Path, ...]) -> Config:
    """The config of a run, later files over earlier ones."""
    parts: list[dict[str, Any]] = []
    for path in paths:
        try:
            content = yaml.safe_load(read_text(path))
        except yaml.YAMLError as error:
            raise InputError(path, f"is not YAML ({str(error).splitlines()[0]}).") from None
        if not isinstance(content, dict):
            raise InputError(path, "holds no mapping of sections.")
        parts.append(content)
    return load(reduce(merged, parts, {}))


def cost(benchmarks: Path, stages: list[str]) -> Table:
    """Hours by stage."""
    jobs = read_jobs(benchmarks.glob("*/*.tsv"), benchmarks)
    rows = [
        Row(
            [Cell(item.stage), Cell(str(item.jobs)), Cell(duration(item.seconds)), Cell(duration(item.cpu_seconds))],
        )
        for item in by_stage(jobs, stages)
    ]
    seconds, processor = (sum(v for v in values if v == v) for values in (
        [job.seconds for job in jobs], [job.cpu_seconds for job in jobs]))  # fmt: skip
    total = Row([Cell("all"), Cell(str(len(jobs))), Cell(duration(seconds)), Cell(duration(processor))], "total")
    notes = ["Job time adds up jobs that ran side by side: on two busy cores the clock shows about half of it."]
    return Table("cost", "Time.", ["Stage", "Jobs", "Job time", "CPU time"], [*rows, total], notes=notes)


def cpu() -> str:
    """Model and number of this machine's cores."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "unknown")
    return f"{os.cpu_count()} cores, {model}"


def facts(target: str, configs: tuple[Path, ...], commit: str, machine: str, told: Iterable[tuple[str, str]]) -> str:
    """How it was made, and what else is told of it."""
    command = f"`snakemake --cores {os.cpu_count()} {target} --configfile {' '.join(map(str, configs))}`"
    known = [("Command", command), ("Commit", f"`{commit}`" if commit else ""), ("Machine", machine or cpu()), *told]
    return "\n".join(f"* {name}: {text}" for name, text in known if text) + "\n"
