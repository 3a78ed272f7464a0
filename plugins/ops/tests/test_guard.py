"""One workflow per folder, and jobs that end with their workflow."""

import errno
import fcntl
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from roomkin.plugins.ops.guard import (
    LOCK,
    WORKFLOW,
    Holder,
    asks_for_run,
    descendants,
    hold_folder,
    start_time,
    stop_if_taken_over,
)
from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.contracts import write_atomically
from tests.refusals import refused

HOLD = "import sys, roomkin.plugins.ops.guard as g; lock = g.hold_folder(); print('held', flush=True); sys.stdin.read()"
# keeps Python's lock for long in native code, as the renderer does
WATCH = """
import roomkin.plugins.ops.guard as g
g.LOOK_EVERY = 0.1
g.end_with_workflow()
print("on", flush=True)
sum(range(10**11))
"""
FAR = Holder(7, "5", "another-machine pid:[1]", "node7")


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
    half = [Path("results/a/.partial-00-b.json"), Path("results/.partial-01-model/mesh.obj")]
    for path in half:
        path.parent.mkdir(parents=True)
        path.touch()
    with refused("E-FOLDER-BUSY") as caught:
        hold_folder()
    assert f"process {other.pid} on " in str(caught.value)
    assert all(path.exists() for path in [stale, *half]), "what a running workflow has is not touched"
    other.kill()
    other.wait()
    with hold_folder():
        assert not stale.exists(), "Snakemake's locks of a dead workflow are removed"
        assert list(Path("results").rglob("*")) == [Path("results/a")], "and what it had begun to write"
        assert Holder.read(os.environ[WORKFLOW]) == Holder.this_process() == Holder.read(LOCK.read_text())


def test_a_filesystem_without_locks_leaves_them_to_snakemake_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(WORKFLOW, "")
    monkeypatch.setattr(fcntl, "flock", refuse)
    lock = LOCK.parent / "locks" / "0.output.lock"
    lock.parent.mkdir(parents=True)
    lock.touch()
    with hold_folder():
        assert lock.exists(), "it may be that of a workflow that runs"
    assert "no locks (No locks available)" in capsys.readouterr().err


def test_what_a_job_has_begun_is_not_written_once_another_workflow_has_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(WORKFLOW, FAR.text)
    monkeypatch.setattr("roomkin.stages.contracts.files.BEFORE_WRITING", [stop_if_taken_over])
    LOCK.parent.mkdir()
    LOCK.write_text(FAR.text)
    with write_atomically(Path("a.txt")) as first, write_atomically(Path("a.txt")) as second:
        assert first != second, "two writers never share a file"
        first.write_text("1")
        second.write_text("2")
    assert Path("a.txt").read_text() == "1"
    with refused("E-FOLDER-TAKEN"):  # noqa: SIM117
        with write_atomically(Path("a.txt")) as path:
            path.write_text("3")
            LOCK.write_text(Holder.this_process().text)
    with refused("E-FOLDER-TAKEN"), atomic_folder(Path("a.txt")):
        pass  # a model's folder, which would replace it
    assert Path("a.txt").read_text() == "1"
    assert not list(tmp_path.glob(".partial-*"))


def test_a_job_on_another_machine_ends_when_another_workflow_has_its_folder(tmp_path: Path) -> None:
    lock = tmp_path / LOCK
    lock.parent.mkdir()
    lock.write_text(FAR.text)
    job = start(sys.executable, "-c", WATCH, env=os.environ | {WORKFLOW: FAR.text}, cwd=tmp_path)
    says(job, "on")
    assert not gone(job.pid, 0.5)
    lock.write_text(FAR._replace(pid=8).text)
    assert gone(job.pid)
    late = start(sys.executable, "-c", WATCH, env=os.environ | {WORKFLOW: FAR.text}, cwd=tmp_path)
    assert late.communicate(timeout=20)[0] == "" and late.returncode == -signal.SIGKILL


def test_descendants_are_children_and_theirs() -> None:
    job = start("bash", "-c", "bash -c 'sleep 61 & echo on; wait' & wait")
    says(job, "on")
    expected, names, until = ["bash", "sleep"], [], time.monotonic() + 20
    while names != expected and time.monotonic() < until:  # a child bears bash's name until it has become sleep
        below = descendants(job.pid)
        names = [Path(f"/proc/{pid}/comm").read_text().strip() for pid in below]
    assert names == expected
    for pid in [job.pid, *below]:
        os.kill(pid, signal.SIGKILL)
    job.wait()


@pytest.mark.parametrize("command", [(), ("-m", "roomkin.plugins.ops.guard")], ids=["stage", "foreign program"])
def test_a_job_ends_with_its_workflow(command: tuple[str, ...]) -> None:
    workflow = start("sleep", "60")
    holder = Holder.this_process()._replace(pid=workflow.pid, started=start_time(workflow.pid))
    environment = os.environ | {WORKFLOW: holder.text}
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
    dead = Holder.this_process()._replace(pid=999999999, started="5")
    job = start(sys.executable, "-c", WATCH, env=os.environ | {WORKFLOW: dead.text})
    assert job.wait(20) == -signal.SIGKILL
    assert job.communicate()[0] == ""


@pytest.mark.parametrize("known", ["", "1\t0", FAR.text, "nonsense"])
def test_a_job_without_its_workflow_here_runs_on(known: str, tmp_path: Path) -> None:
    job = start(sys.executable, "-c", WATCH, cwd=tmp_path, env=os.environ | {WORKFLOW: known})
    says(job, "on")
    assert not gone(job.pid, 0.3)
    job.kill()


def test_a_foreign_program_keeps_its_exit_code_and_a_missing_one_is_one_line() -> None:
    guard = [sys.executable, "-m", "roomkin.plugins.ops.guard"]
    assert subprocess.call([*guard, "sh", "-c", "exit 7"]) == 7
    done = subprocess.run([*guard, "./none.sh"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (127, "error: ./none.sh: cannot be run (No such file or directory).\n")


def test_commands_that_only_look_need_no_lock() -> None:
    assert asks_for_run(["snakemake", "--cores", "2", "all"])
    assert not asks_for_run(["snakemake", "--report=report.html"])
    assert not asks_for_run(["snakemake", "--summary"])
