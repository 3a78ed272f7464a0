"""One workflow per folder, and jobs that end with their workflow."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stages.contracts import InputError
from stages.guard import LOCK, WORKFLOW, descendants, here, hold_folder, makes_files, start_time

HOLD = "import sys, stages.guard as g; lock = g.hold_folder(); print('held', flush=True); sys.stdin.read()"
# keeps Python's lock for long in native code, as the renderer does
WATCH = "import stages.guard as g; g.end_with_workflow(); print('on', flush=True); sum(range(10**11))"


def start(*command: str, **options: object) -> subprocess.Popen[str]:
    return subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True, **options)  # type: ignore[call-overload, no-any-return]


def says(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdout is not None and process.stdout.readline().strip() == word


def gone(pid: int, seconds: float = 5.0) -> bool:
    """Whether a process ends within `seconds`; one that waits to be collected has ended."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        stat = Path(f"/proc/{pid}/stat")
        if not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z":
            return True
        time.sleep(0.05)
    return False


def test_a_folder_is_held_by_one_workflow_and_let_go_by_kill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(WORKFLOW, "")
    other = start(sys.executable, "-c", HOLD, cwd=tmp_path)
    says(other, "held")
    stale = LOCK.parent / "locks" / "0.output.lock"
    stale.parent.mkdir()
    stale.write_text("results/a\n")
    with pytest.raises(InputError, match=f"another workflow is running here \\(process {other.pid}\\)"):
        hold_folder()
    assert stale.exists(), "the locks of a workflow that runs are not touched"
    other.kill()
    other.wait()
    with hold_folder():
        assert not stale.exists(), "Snakemake's locks of a dead workflow are removed"
        assert os.environ[WORKFLOW] == f"{os.getpid()} {start_time(os.getpid())} {here()}"


@pytest.mark.parametrize("command", [(), ("-m", "stages.guard")], ids=["stage", "foreign program"])
def test_a_job_ends_with_its_workflow(command: tuple[str, ...]) -> None:
    workflow = start("sleep", "60")
    environment = os.environ | {WORKFLOW: f"{workflow.pid} {start_time(workflow.pid)} {here()}"}
    if command:
        job = start(sys.executable, *command, "bash", "-c", "sleep 61 & echo on; wait", env=environment)
    else:
        job = start(sys.executable, "-c", WATCH, env=environment)
    says(job, "on")
    below = descendants(job.pid)
    assert len(below) >= 2 * bool(command)
    workflow.kill()
    workflow.wait()
    assert all(gone(pid) for pid in [job.pid, *below])


def test_a_job_that_starts_after_its_workflow_ended_ends_at_once() -> None:
    job = start(sys.executable, "-c", WATCH, env=os.environ | {WORKFLOW: f"999999999 5 {here()}"})
    assert job.wait(20) == -signal.SIGKILL
    assert job.communicate()[0] == ""


@pytest.mark.parametrize("known", ["", "1 0", "999999999 5 another-machine pid:[1]", "nonsense"])
def test_a_job_without_its_workflow_here_runs_on(known: str) -> None:
    job = start(sys.executable, "-c", WATCH, env=os.environ | {WORKFLOW: known})
    says(job, "on")
    assert not gone(job.pid, 0.3)
    job.kill()


def test_a_foreign_program_keeps_its_exit_code_and_a_missing_one_is_one_line() -> None:
    guard = [sys.executable, "-m", "stages.guard"]
    assert subprocess.call([*guard, "sh", "-c", "exit 7"]) == 7
    done = subprocess.run([*guard, "./none.sh"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (127, "error: ./none.sh: cannot be run (No such file or directory).\n")


def test_commands_that_only_look_need_no_lock() -> None:
    assert makes_files(["snakemake", "--cores", "2", "all"])
    assert not makes_files(["snakemake", "--report=report.html"])
    assert not makes_files(["snakemake", "--summary"])
