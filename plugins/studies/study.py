"""About a study: its configs, its machine, its cost."""

import os
from collections.abc import Iterable
from pathlib import Path

from plugins.report.page.benchmarks import by_stage, read_jobs, times_table
from stages.tables.markup import Table


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
