"""Whose a folder is: the line that a running workflow writes into its lock file and hands to its jobs."""

import os
import socket
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
