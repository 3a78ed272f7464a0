"""Kill a run again and again, finish it, and compare its results with those of a run that nobody disturbed.

`python -m tests.workflow.kill --kills 20` does it for the micro config from an empty folder (ten minutes or more).
"""

import argparse
import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from hashlib import sha256
from pathlib import Path

from roomkin.plugins.ops.guard import descendants
from tests.workflow.workspace import MICRO, make

KINDS = ("process group", "workflow", "job")  # what is killed
# All else below results/ is the same, byte for byte, whenever it is made.
HOLDS_TIMES = {"report/times.html", ".checksums/report/times.html"}


def digests(results: Path) -> dict[str, str]:
    """sha256 of every file below a results folder."""
    files = sorted(path for path in results.rglob("*") if path.is_file())
    return {path.relative_to(results).as_posix(): sha256(path.read_bytes()).hexdigest() for path in files}


def difference(first: Path, second: Path) -> list[str]:
    """Files that only one of two results folders has, or that differ and hold no times."""
    a, b = digests(first), digests(second)
    return sorted(name for name in (a.keys() | b.keys()) - HOLDS_TIMES if a.get(name) != b.get(name))


def processes_in(folder: Path) -> list[int]:
    """Processes that work in a folder, zombies left out."""
    pids = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").readlink() == folder and (process / "cmdline").read_bytes():
                pids.append(int(process.name))
        except OSError:
            continue
    return pids


def start(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Snakemake in a process group of its own; what it prints is appended to kill.log."""
    command = [str(Path(sys.executable).parent / "snakemake"), "--cores", "2", *arguments]
    with (folder / "kill.log").open("ab") as log:
        return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, start_new_session=True)


def kill(workflow: subprocess.Popen[bytes], kind: str, chance: random.Random) -> None:
    """Send SIGKILL to a part of a running workflow, and wait for its end."""
    jobs = descendants(workflow.pid)
    if kind == "process group":
        os.killpg(workflow.pid, signal.SIGKILL)
    elif kind == "job" and jobs:
        with contextlib.suppress(ProcessLookupError):
            os.kill(chance.choice(jobs), signal.SIGKILL)
    else:
        workflow.kill()
    workflow.wait()


def killed_run(folder: Path, arguments: tuple[str, ...], moments: list[float], seed: int = 0) -> list[str]:
    """Start the workflow and kill it after each of `moments` (seconds from its first job on), then let it finish.

    Returns:
        what was killed, one word for each kill that met a running workflow.

    Raises:
        RuntimeError: a process was left running five seconds after a kill, or the last run failed.
    """
    chance, killed = random.Random(seed), []
    for number, moment in enumerate(moments):
        workflow = start(folder, *arguments)
        while workflow.poll() is None and not descendants(workflow.pid):
            time.sleep(0.05)
        try:
            workflow.wait(moment)
        except subprocess.TimeoutExpired:
            kill(workflow, KINDS[number % len(KINDS)], chance)
            killed.append(KINDS[number % len(KINDS)])
        until = time.monotonic() + 5
        while processes_in(folder) and time.monotonic() < until:
            time.sleep(0.1)
        if left := processes_in(folder):
            raise RuntimeError(f"processes {left} are left after killing the {killed[-1:]}")
    if start(folder, *arguments).wait() != 0:
        raise RuntimeError(f"the run did not go on:\n{(folder / 'kill.log').read_text()[-3000:]}")
    return killed


def main() -> int:
    """Exit code 0 if the disturbed run ends as the undisturbed one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--longest", type=float, default=40.0, help="seconds of jobs until a kill, at most")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=None, help="kept if given")
    options = parser.parse_args()
    home = (options.folder or Path(tempfile.mkdtemp())).resolve()
    quiet, disturbed = make(home / "undisturbed"), make(home / "disturbed")
    if start(quiet, "all", *MICRO).wait() != 0:
        print((quiet / "kill.log").read_text()[-3000:])
        return 1
    chance = random.Random(options.seed)
    killed: list[str] = []
    while len(killed) < options.kills:  # a run that got through before all kills starts anew
        shutil.rmtree(disturbed / "results", ignore_errors=True)
        moments = [chance.uniform(2, options.longest) for _ in range(options.kills - len(killed))]
        killed += killed_run(disturbed, ("all", *MICRO), moments, options.seed)
    different = difference(quiet / "results", disturbed / "results")
    print(f"{len(killed)} kills ({', '.join(f'{killed.count(kind)} {kind}' for kind in KINDS)});", end=" ")
    print("all results equal" if not different else f"{len(different)} files differ: {', '.join(different)}")
    if options.folder is None:
        shutil.rmtree(home)
    return int(bool(different))


if __name__ == "__main__":
    sys.exit(main())
