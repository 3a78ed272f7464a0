"""Jobs that a killed workflow left in SLURM's queue, known by the line that it wrote into its folder's lock."""

import os
import re
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

from roomkin.stages.contracts.errors import InputError

WORKFLOW = "ACDC_WORKFLOW"  # environment variable of all jobs: the line of the workflow that started them
LOCK = Path(".snakemake/acdc.lock")  # on a filesystem that all jobs of a workflow share


class Holder(NamedTuple):
    """A workflow that runs, or ran: no two are alike.

    Attributes:
        pid: its process.
        started: when that process started, in clock ticks since boot.
        place: its machine since the last start, and the namespace of its process ids; '' where there is no /proc.
        host: the machine's name.
    """

    pid: int
    started: str
    place: str
    host: str

    @classmethod
    def this_process(cls) -> "Holder":
        """The process that asks."""
        return cls(os.getpid(), start_time(os.getpid()), _place(), socket.gethostname())

    @classmethod
    def read(cls, text: str) -> "Holder | None":
        """The workflow that a line names; None if it names none."""
        words = text.strip().split("\t")
        return cls(int(words[0]), *words[1:]) if len(words) == 4 and words[0].isdigit() else None

    @property
    def text(self) -> str:
        """The line."""
        return "\t".join(map(str, self))


def start_time(pid: int) -> str:
    """When a process started, in clock ticks since boot, so that a pid used again is not taken for it; '' if gone."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return ""
    return stat.rpartition(")")[2].split()[19]


def _place() -> str:
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8").strip()
        return f"{boot} {Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        return ""


def is_taken_over() -> bool:
    """Whether another workflow holds the folder that this process is a job of: it must write nothing there any more."""
    mine = Holder.read(os.environ.get(WORKFLOW, ""))
    if mine is None:
        return False
    try:
        holder = Holder.read(LOCK.read_text(encoding="utf-8"))
    except OSError:
        return False
    return holder not in (None, mine)


def stop_if_taken_over(path: Path) -> None:
    """Refuse to put a result into its place in a folder that another workflow has taken over.

    Raises:
        InputError: it has.
    """
    if is_taken_over():
        raise InputError(path, "is not written: another workflow has taken over this folder.", code="E-FOLDER-TAKEN")


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
