"""What the operating system refuses is one line with the file's name, and what is finished is on the disk."""

import errno
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import h5py
import numpy as np
import pandas as pd
import pytest
from PIL import Image

from roomkin.stages.contracts import system
from roomkin.stages.contracts.__main__ import main as check
from roomkin.stages.contracts.arrays import read_npz
from roomkin.stages.contracts.errors import file_missing
from roomkin.stages.contracts.files import read_text, write_atomically, write_json
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.system import line_of
from roomkin.stages.training.state import Logbook
from tests.refusals import refused

NOISE = np.random.default_rng(0).integers(0, 255, (200, 200, 3), np.uint8)


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["x"] = NOISE


WRITERS: dict[str, Callable[[Path], object]] = {
    "text.json": lambda path: path.write_text("x" * 100_000),
    "table.csv": lambda path: pd.DataFrame(NOISE[0]).to_csv(path),
    "arrays.npz": lambda path: np.savez(path, a=NOISE),
    "pillow.png": lambda path: Image.fromarray(NOISE).save(path),
    "opencv.png": lambda path: cv2.imwrite(str(path), NOISE),
    "store.h5": hdf5,
}


@contextmanager
def little_room(size: int = 1000) -> Iterator[None]:
    """No file grows beyond `size` bytes, as if the disk were full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_file_that_cannot_be_written_is_named_and_the_old_one_stays(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("old")
    with pytest.raises(OSError) as caught, little_room(), write_atomically(tmp_path / name) as temporary:
        WRITERS[name](temporary)
    line = line_of(caught.value)
    assert line and line.startswith(f"{tmp_path / name}: ") and "\n" not in line and ".partial" not in line
    assert [path.name for path in tmp_path.iterdir()] == [name] and (tmp_path / name).read_text() == "old"


def test_the_log_of_a_training_is_named(tmp_path: Path) -> None:
    logbook = Logbook(tmp_path / "metrics.jsonl", [], "disabled", tmp_path, {})
    with pytest.raises(OSError, match=r"metrics\.jsonl"), little_room(10):
        logbook.write({"step": 1, "loss": 0.123456789})


@contextmanager
def disk(folder: Path, options: str) -> Iterator[Path]:
    """A filesystem in memory, mounted on a folder."""
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], capture_output=True).returncode:
        pytest.skip("needs to mount a filesystem")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


FILL = """
import sys
from pathlib import Path
import numpy as np
from roomkin.stages.contracts.features import FeatureIndex
from roomkin.stages.contracts.system import line_of
from roomkin.stages.matching.store import write_store
index = FeatureIndex(encoder="x", settings="0" * 12, upright=True, assets=["a"], yaws=[0.0], starts=[0, 9000, 9001])
rows = [np.ones((9000, 50), np.float16), np.ones((1, 50), np.float16)]
try:
    write_store(Path(sys.argv[1]), index, rows, [np.ones(3, np.float16)] * 2, None)
except OSError as error:
    print(line_of(error))
"""


def test_features_on_a_full_disk_are_a_line_and_leave_nothing(tmp_path: Path) -> None:
    with disk(tmp_path / "small", "size=400k") as small:
        command = [sys.executable, "-c", FILL, str(small / "shard.npy")]
        done = subprocess.run(command, capture_output=True, text=True)  # by itself: SIGBUS ends the process
        assert done.returncode == 0, (done.returncode, done.stderr)
        assert done.stdout.startswith(f"{small / 'shard.npy'}: No space left on device. Fix: make room")
        assert not list(small.iterdir())


@pytest.mark.parametrize("name", list(WRITERS))
def test_a_disk_that_cannot_be_written_says_so(tmp_path: Path, name: str) -> None:
    mounted = disk(tmp_path / "fixed", "ro")
    with mounted as fixed, pytest.raises(OSError) as caught, write_atomically(fixed / name) as temporary:
        WRITERS[name](temporary)
    line = f"{fixed / name}: Read-only file system. Fix: choose a folder that can be written [E-SYSTEM]"
    assert line_of(caught.value) == line


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError(errno.ENOSPC, "x", "a.json"), "a.json: No space left on device. Fix: make room on the disk"),
        (OSError(errno.EROFS, "x", "a.json"), "a.json: Read-only file system. Fix: choose a folder"),
        (PermissionError(errno.EACCES, "x", "a.json"), "a.json: Permission denied. Fix: choose a folder"),
        (MemoryError("Unable to allocate 9 TiB"), "out of memory. Fix: run fewer jobs"),
        (RuntimeError("DefaultCPUAllocator: can't allocate memory"), "out of memory"),
        (OSError("two\nlines"), "two lines."),
    ],
)
def test_lines(error: Exception, line: str) -> None:
    assert str(line_of(error)).startswith(line)


def test_lines_have_codes() -> None:
    assert str(line_of(MemoryError())).endswith(" [E-SYSTEM-MEMORY]")
    assert str(line_of(OSError(errno.EACCES, "x", "a"))).endswith(" [E-SYSTEM]")


def test_other_errors_are_ours() -> None:
    assert line_of(ValueError("x")) is None and line_of(RuntimeError("x")) is None


def test_a_stage_ends_with_one_line() -> None:
    command = [sys.executable, "-m", "roomkin.plugins.furniture", "library", "--out", "/proc/none/library.json"]
    done = subprocess.run([*command, "--options", '{"counts": {"mug": 1}}'], capture_output=True, text=True)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert done.stderr.strip().splitlines()[-1].startswith("error: /proc/none: ")


def test_a_check_ends_with_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "truth.json").write_text("{}")

    def refuse(*_: object) -> None:
        raise OSError(errno.EROFS, "x", "truth.json")

    monkeypatch.setattr(Path, "replace", refuse)
    assert check(["--refuse", "truth", str(tmp_path / "truth.json")]) == 1
    assert capsys.readouterr().err.startswith("error: truth.json: Read-only file system.")


def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    fsync, replace = os.fsync, Path.replace

    def synced(descriptor: int) -> None:
        done.append(f"sync {Path(f'/proc/self/fd/{descriptor}').readlink().name}")
        fsync(descriptor)

    def named(path: Path, target: Path) -> Path:
        done.append(f"name {target.name}")
        return replace(path, target)

    monkeypatch.setattr(system.os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", named)
    write_json(tmp_path / "a.json", {"a": 1})
    assert done[0].startswith("sync .partial-") and done[1:] == ["name a.json", f"sync {tmp_path.name}"]


def test_a_folder_is_synced_with_all_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "models/cup").mkdir(parents=True)
    (tmp_path / "models/cup/a.obj").write_text("o")
    done: set[str] = set()
    monkeypatch.setattr(system.os, "fsync", lambda fd: done.add(Path(f"/proc/self/fd/{fd}").readlink().name))
    system.sync(tmp_path)
    assert done == {tmp_path.name, "models", "cup", "a.obj"}


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    system.check_writable(tmp_path, tmp_path / "not there yet")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # as root may write everywhere but on a read-only disk
    with refused("E-FOLDER-READ-ONLY", str(tmp_path)):
        system.check_writable(tmp_path)


def test_a_pipe_or_a_folder_in_the_place_of_a_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "annotations.json")
    with refused("E-FILE-UNREADABLE", "pipe"):
        read_text(tmp_path / "annotations.json")
    (tmp_path / "depth.npz").mkdir()
    with refused("E-FILE-UNREADABLE", "depth.npz: is no file, but a folder"):
        read_npz(tmp_path / "depth.npz")


@pytest.mark.parametrize("read", [read_text, read_rgb, read_npz])
def test_a_file_that_is_not_there_names_the_nearest_that_is(tmp_path: Path, read: Callable[[Path], object]) -> None:
    for name in ("depth.png", "depth.npz", "rgb.jpg"):
        (tmp_path / name).touch()
    (tmp_path / "notes").mkdir()
    for asked, meant in (("dept.png", "depth.png"), ("dept.npz", "depth.npz"), ("rgb.png", "rgb.jpg")):
        with refused("E-FILE-MISSING", f"{asked}: no such file. Fix: did you mean '{tmp_path / meant}'?"):
            read(tmp_path / asked)
    for asked in ("note", "other.png", "no folder/depth.png"):
        with refused("E-FILE-MISSING") as caught:
            read(tmp_path / asked)
        assert "did you mean" not in str(caught.value)


def test_what_helps_against_a_missing_file_stands_behind_what_was_meant(tmp_path: Path) -> None:
    assert file_missing(tmp_path / "seed_1.h5").fix == "correct the path"
    assert file_missing(tmp_path / "seed_1.h5", "collect again").fix == "collect again"
    (tmp_path / "seed_10.h5").touch()
    said = file_missing(tmp_path / "seed_1.h5", "collect again").fix
    assert said == f"did you mean '{tmp_path / 'seed_10.h5'}'? Else collect again"
