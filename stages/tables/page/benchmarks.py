"""Where the time went: the benchmark files that Snakemake wrote."""

import csv
import io
import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stages.contracts.errors import InputError
from stages.contracts.files import read_text

MENDING = "delete it and run its rule again"


@dataclass(frozen=True)
class Job:
    """One benchmarked job: wall and CPU seconds, peak resident memory in MiB (NaN: not measured)."""

    stage: str
    name: str
    seconds: float
    cpu_seconds: float
    memory: float


@dataclass(frozen=True)
class StageTime:
    """All jobs of a stage; `share` is its part of the job seconds of the run."""

    stage: str
    jobs: int
    seconds: float
    cpu_seconds: float
    memory: float
    share: float


def _number(value: Any) -> float:
    """A cell as a number; '-' and 'NA' mean that a short job was not measured."""
    return math.nan if value in (None, "", "-", "NA") else float(value)


def _lines(path: Path) -> list[dict[str, Any]]:
    text = read_text(path)
    if path.suffix == ".jsonl":
        return [json.loads(line) for line in text.splitlines() if line.strip()]
    return list(csv.DictReader(io.StringIO(text), delimiter="\t"))


def read_jobs(paths: Iterable[Path], root: Path) -> list[Job]:
    """The jobs of this run whose benchmark files lie below `root`, its first level being the stage; sorted by path.

    A file that is not there is left out: Snakemake writes none for a job that ran before benchmarks were asked for.

    Raises:
        InputError: a file is no benchmark file.
    """
    jobs = []
    for path in sorted(path for path in set(paths) if path.is_file()):
        inner = path.relative_to(root)
        try:
            for line in _lines(path):
                numbers = [_number(line[name]) for name in ("s", "cpu_time", "max_rss")]
                jobs.append(Job(inner.parts[0], str(inner.with_suffix("")), *numbers))
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(path, f"is not a benchmark file of Snakemake ({error}).", MENDING) from None
    return jobs


def _sum(values: list[float]) -> float:
    return sum(value for value in values if not math.isnan(value))


def by_stage(jobs: list[Job], stages: list[str]) -> list[StageTime]:
    """Sums and peaks per stage, in the order of `stages`, others after them."""
    total = _sum([job.seconds for job in jobs]) or 1.0
    found = {job.stage for job in jobs}
    rows = []
    for stage in [*(name for name in stages if name in found), *sorted(found - set(stages))]:
        mine = [job for job in jobs if job.stage == stage]
        seconds = _sum([job.seconds for job in mine])
        peaks = [job.memory for job in mine if not math.isnan(job.memory)]
        cpu = _sum([job.cpu_seconds for job in mine])
        rows.append(StageTime(stage, len(mine), seconds, cpu, max(peaks, default=math.nan), seconds / total))
    return rows


def duration(seconds: float) -> str:
    """'42 s', '3 min 20 s' or '2 h 05 min'."""
    whole = round(seconds)
    if whole < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
