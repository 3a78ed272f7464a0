"""Jobs that a killed workflow left in SLURM's queue."""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

LOGS = Path(".snakemake/slurm_logs")  # the executor plugin makes it before it submits anything
RUN = re.compile(r"(^|_)[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$")  # how it names the jobs of a run
PATIENCE = 90.0  # seconds: SLURM gives a cancelled job half a minute by default before it kills it


class Job(NamedTuple):
    """A job of this user in the queue: a task of an array is one."""

    id: str
    name: str
    folder: str


def list_jobs() -> list[Job]:
    """The jobs of this user; [] if SLURM does not answer."""
    command = ["squeue", "--me", "--noheader", "--format=%i|%j|%Z"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return []
    return [Job(*line.split("|", 2)) for line in done.stdout.splitlines() if line.count("|") >= 2]


def list_left_over_jobs(folder: Path) -> list[str]:
    """Ids of the jobs that a workflow in this folder submitted."""
    return [job.id for job in list_jobs() if RUN.search(job.name) and Path(job.folder) == folder]


def cancel_left_over(folder: Path) -> None:
    """Cancel the jobs that a killed workflow left, and wait until they have ended. The folder must be locked."""
    if not (folder / LOGS).is_dir() or not shutil.which("squeue"):
        return
    jobs, until = list_left_over_jobs(folder), time.monotonic() + PATIENCE
    if not jobs:
        return
    print(f"note: cancelling SLURM jobs that a killed run left here: {' '.join(jobs)}", file=sys.stderr)
    subprocess.run(["scancel", *jobs], check=False)
    while left := list_left_over_jobs(folder):
        if time.monotonic() > until:
            print(f"note: SLURM jobs {' '.join(left)} do not end; what they make is not used", file=sys.stderr)
            return
        time.sleep(1)
