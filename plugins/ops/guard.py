"""Stopping and starting: one workflow per folder, and no job that outlives its workflow, however it was killed.

`python -m roomkin.plugins.ops.guard COMMAND ...` runs any other program with the same promise.
"""

import contextlib
import fcntl
import os
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, NamedTuple

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import BEFORE_WRITING, PARTIAL
from roomkin.stages.contracts.system import JOB_START

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


# Options with which Snakemake runs no job: they may be used while a workflow is running.
LOOKS = {"--report", "--lint", "-l", "--list-rules", "--list", "--summary", "-S", "--detailed-summary", "-D", "--dag",
         "--rulegraph", "--filegraph", "--d3dag", "--list-changes", "--list-params-changes", "--list-input-changes",
         "--list-untracked", "--containerize", "--generate-unit-tests", "--unlock"}  # fmt: skip
LOOK_EVERY = 5.0  # seconds: how often a job on another machine looks whose the folder is


def asks_for_run(arguments: list[str]) -> bool:
    """Whether a command line of Snakemake asks for a run."""
    return not LOOKS & {argument.partition("=")[0] for argument in arguments}


def hold_folder(results: Path = Path("results")) -> IO[str]:
    """Lock the working directory for this process; the kernel lets go of the lock when the process dies.

    Snakemake's own locks outlive a killed workflow: those that are left while nobody holds this one are removed, and so
    are half-written files below `results`. Jobs that a killed workflow left on a cluster are ended: those of SLURM are
    cancelled here, all others see that the folder is no longer theirs (`end_with_workflow`). On a filesystem that has
    no locks Snakemake's own are left alone, and a line says so.

    Returns:
        the open lock file: the folder is locked as long as it is open.

    Raises:
        InputError: another workflow is running in this folder.
    """
    LOCK.parent.mkdir(exist_ok=True)
    file = LOCK.open("a+", encoding="utf-8")
    file.seek(0)
    before = Holder.read(file.read())
    locked = True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        owner = f"process {before.pid} on {before.host}" if before else "process unknown"
        what = f"another workflow is running here ({owner})."
        raise InputError(Path.cwd(), what, "wait until it ends, or stop it", code="E-FOLDER-BUSY") from None
    except OSError as error:
        locked = False
        print(
            f"note: {Path.cwd()}: this filesystem has no locks ({error.strerror}), Snakemake's own takes their place: "
            "after a kill -9, and if nothing runs here, `snakemake --unlock` first",
            file=sys.stderr,
        )
    file.truncate(0)
    file.write(Holder.this_process().text)
    file.flush()
    os.environ.update({WORKFLOW: Holder.this_process().text, JOB_START: "roomkin.plugins.ops.guard:end_with_workflow"})
    if locked:
        shutil.rmtree(LOCK.parent / "locks", ignore_errors=True)
        cancel_left_over(Path.cwd())
        sweep(results)
    return file


def sweep(folder: Path) -> None:
    """Remove what killed jobs had begun to write."""
    for place, folders, files in os.walk(folder):
        for name in [name for name in folders if name.startswith(PARTIAL)]:
            folders.remove(name)
            shutil.rmtree(Path(place, name), ignore_errors=True)
        for name in [name for name in files if name.startswith(PARTIAL)]:
            Path(place, name).unlink(missing_ok=True)


def end_with_workflow() -> None:
    """Let this process, and all that it starts, be killed when the workflow that started it is gone.

    A child of its own watches, since a thread waits for as long as native code keeps Python's lock (seconds, while
    shaders are compiled). Outputs are written atomically, so that nothing half-written stays. A job on another machine,
    or in a container with processes of its own, cannot see its workflow: it ends when another one has taken over the
    folder that both share. Nothing is done for a process started by hand.
    """
    workflow = Holder.read(os.environ.get(WORKFLOW, ""))
    if workflow is None:
        return
    BEFORE_WRITING.append(stop_if_taken_over)
    job = os.getpid()
    near = bool(workflow.place) and workflow.place == Holder.this_process().place
    watched = []
    try:
        watched.append(os.pidfd_open(job))
        if near:
            watched.append(os.pidfd_open(workflow.pid))
        alive = start_time(workflow.pid) == workflow.started if near else not is_taken_over()
    except OSError:
        alive = False
    if not alive:
        kill_all(job)
    if os.fork():
        return
    try:
        ended: list[int] = []
        while not ended and not is_taken_over():
            ended = select.select(watched, [], [], None if near else LOOK_EVERY)[0]
        if watched[0] not in ended:
            kill_all(job)
    finally:
        os._exit(0)


def kill_all(job: int) -> None:
    """SIGKILL for a process and all below it but this one, which comes last if it is among them."""
    for pid in sorted([*descendants(job), job], key=lambda pid: pid == os.getpid()):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def descendants(pid: int) -> list[int]:
    """Process ids below `pid`, parents before children."""
    children = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            children += [int(child) for child in task.read_text().split()]
        except OSError:
            continue
    return [found for child in children for found in (child, *descendants(child))]


def run(command: list[str]) -> int:
    """Run a program that knows nothing of the workflow, and end it and all it started with the workflow."""
    end_with_workflow()
    try:
        return subprocess.call(command)
    except OSError as error:
        print(f"error: {command[0]}: cannot be run ({error.strerror}).", file=sys.stderr)
        return 127


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
