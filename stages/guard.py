"""Stopping and starting: one workflow per folder, and no job that outlives its workflow, however it was killed.

`python -m stages.guard COMMAND ...` runs any other program with the same promise.
"""

import contextlib
import fcntl
import os
import select
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO

from stages.contracts.errors import InputError

WORKFLOW = (
    "ACDC_WORKFLOW"  # environment variable of all jobs: pid and start time of the workflow's process, and where it runs
)
LOCK = Path(".snakemake/acdc.lock")
# Options with which Snakemake runs no job: they may be used while a workflow is running.
LOOKS = {"--report", "--lint", "-l", "--list-rules", "--list", "--summary", "-S", "--detailed-summary", "-D", "--dag",
         "--rulegraph", "--filegraph", "--d3dag", "--list-changes", "--list-params-changes", "--list-input-changes",
         "--list-untracked", "--containerize", "--generate-unit-tests", "--unlock"}  # fmt: skip


def makes_files(arguments: list[str]) -> bool:
    """Whether a command line of Snakemake asks for a run."""
    return not LOOKS & {argument.partition("=")[0] for argument in arguments}


def start_time(pid: int) -> str:
    """When a process started, in clock ticks since boot, so that a pid used again is not taken for it; '' if gone."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return ""
    return stat.rpartition(")")[2].split()[19]


def here() -> str:
    """This machine since its last start, and the namespace of its process ids; '' where there is no /proc."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="utf-8").strip()
        return f"{boot} {Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        return ""


def hold_folder() -> IO[str]:
    """Lock the working directory for this process; the kernel lets go of the lock when the process dies.

    Snakemake's own locks outlive a killed workflow: those that are left while nobody holds this one are removed.

    Returns:
        the open lock file: the folder is locked as long as it is open.

    Raises:
        InputError: another workflow is running in this folder.
    """
    LOCK.parent.mkdir(exist_ok=True)
    file = LOCK.open("a+", encoding="utf-8")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.seek(0)
        owner = file.read().strip() or "unknown"
        raise InputError(
            Path.cwd(), f"another workflow is running here (process {owner}).", "wait until it ends, or stop it"
        ) from None
    file.truncate(0)
    file.write(f"{os.getpid()}\n")
    file.flush()
    shutil.rmtree(LOCK.parent / "locks", ignore_errors=True)
    os.environ[WORKFLOW] = f"{os.getpid()} {start_time(os.getpid())} {here()}"
    return file


def end_with_workflow() -> None:
    """Let this process, and all that it starts, be killed when the workflow that started it is gone.

    A child of its own watches, since a thread waits for as long as native code keeps Python's lock (seconds, while
    shaders are compiled). Outputs are written atomically, so that nothing half-written stays. Nothing is done for a
    process started by hand, on another machine, or in a container with processes of its own.
    """
    pid, _, rest = os.environ.get(WORKFLOW, "").partition(" ")
    started, _, place = rest.partition(" ")
    if not pid.isdigit() or not place or place != here():
        return
    job = os.getpid()
    try:
        own, workflow = os.pidfd_open(job), os.pidfd_open(int(pid))
        alive = start_time(int(pid)) == started
    except OSError:
        alive = False
    if not alive:
        kill_all(job)
    if os.fork():
        return
    try:
        ended, _, _ = select.select([workflow, own], [], [])
        if workflow in ended:
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
