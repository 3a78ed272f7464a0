"""Finished results against what was recorded when they were written."""

import base64
import errno
import json
import os
from pathlib import Path
from typing import NoReturn

import h5py
import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.ops import verify
from roomkin.plugins.ops.verify import METADATA, NAMED, list_files, list_for_run, run, warn_of_changed
from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.contracts import files
from roomkin.stages.contracts.__main__ import main as check
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.errors import escape_control
from roomkin.stages.contracts.files import write_atomically, write_json, write_text
from tests.refusals import refused

TABLE = "results/evaluation/rollouts.csv"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a run with a table, JSON, HDF5, a picture, an archive and a folder, whole."""
    monkeypatch.chdir(tmp_path)
    write_text(Path(TABLE), "seed,success\n0,1\n1,0\n")
    write_json(Path("results/camera.json"), {"K": [500.0, 400.0]})
    with write_atomically(Path("results/demos/episodes.h5")) as path, h5py.File(path, "w") as file:
        file["action"] = np.arange(100.0)
    with write_atomically(Path("results/rgb.png")) as path:
        Image.new("RGB", (9, 9), "red").save(path)
    Path("model").mkdir()
    Path("model/base.obj").write_text("v 0 0 0\n")
    pack(Path("model"), tmp_path / "results/assets/shard_0.zip")  # by an absolute path, too
    with atomic_folder(Path("results/exports/lerobot")) as out:
        (out / "info.json").write_text("{}\n")
    return tmp_path


def tell_fault(results: Path = Path("results"), code: str = "E-RESULT-CHANGED") -> str:
    """What is said when something is broken."""
    with refused(code) as caught:
        run(results=results)
    return str(caught.value)


def know(folder: Path, output: str, line: str = "") -> None:
    """What Snakemake keeps of an output."""
    name = base64.urlsafe_b64encode(output.encode()).decode()
    path = folder / METADATA / f"@{name[:10]}" / name[10:]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"shellcmd": line}))


def flip(path: Path, where: float = 0.5) -> None:
    content = bytearray(path.read_bytes())
    content[int(len(content) * where)] ^= 1
    path.write_bytes(content)


def test_what_is_whole_is_told_in_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run()
    assert capsys.readouterr().err == "results: 6 files with a checksum, 0 without\n"


@pytest.mark.parametrize(
    "name",
    [TABLE, "results/camera.json", "results/demos/episodes.h5", "results/rgb.png", "results/assets/shard_0.zip",
     "results/exports/lerobot/info.json"],
)  # fmt: skip
def test_a_flipped_bit_is_named_with_the_command_that_mends_it(folder: Path, name: str) -> None:
    know(folder, "results/exports/lerobot")
    flip(folder / name)
    said = tell_fault()
    assert f"\n  {name}: differs from its checksum" in said and "1 broken" in said
    output = "results/exports/lerobot" if "lerobot" in name else name
    assert f"snakemake --cores 2 --force {output} " in said


def test_a_table_without_its_last_line_is_found(folder: Path) -> None:
    Path(TABLE).write_text("seed,success\n0,1\n")
    assert TABLE in tell_fault()


def test_from_another_folder(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flip(folder / TABLE)
    monkeypatch.chdir("/")
    assert f"{folder / TABLE}: differs" in tell_fault(folder / "results")


def test_what_has_no_checksum_is_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("results/odd.txt").write_text("by hand")
    Path("results/.partial-1-x.csv").write_text("half")
    Path("results/x.json.refused").write_text("{")
    know(folder, "results/lost.csv")
    run()
    said = capsys.readouterr().err
    assert "a change may go unseen: odd.txt\n" in said and "1 without" in said
    assert "no longer there" in said and "results/lost.csv" in said


def test_without_a_checksum_the_contract_is_held(folder: Path) -> None:
    (record,) = folder.glob("results/.checksums/camera.json")
    record.unlink()
    know(
        folder,
        "results/camera.json",
        "(x && python -m roomkin.stages.contracts --refuse truth results/camera.json) 2>&1",
    )
    assert "results/camera.json: results/camera.json: " in tell_fault()


def test_the_same_files_have_the_same_record_and_a_new_file_a_new_one(folder: Path) -> None:
    before = files.read_recorded(Path(TABLE))
    write_text(Path(TABLE), "seed,success\n")
    assert files.read_recorded(Path(TABLE)) not in (None, before)
    write_text(Path(TABLE), "seed,success\n0,1\n1,0\n")
    assert files.read_recorded(Path(TABLE)) == before
    run()


def test_a_kill_before_the_record_leaves_none(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(path: Path) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files, "record", killed)
    monkeypatch.setattr("roomkin.stages.articulated.asset_folder.record", killed)
    with pytest.raises(KeyboardInterrupt):
        write_text(Path(TABLE), "seed\n")
    with pytest.raises(KeyboardInterrupt), atomic_folder(Path("results/exports/lerobot")) as out:
        (out / "info.json").write_text("{ }\n")
    assert files.read_recorded(Path(TABLE)) is None
    assert not Path("results/.checksums/exports/lerobot").exists()


def test_half_a_record_is_none(folder: Path) -> None:
    record = files.record_of(Path(TABLE))
    assert record
    record.write_text(record.read_text()[:30])
    assert files.read_recorded(Path(TABLE)) is None


def test_what_is_no_result_gets_no_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_text(Path("other/a.csv"), "a\n")
    write_text(Path("results/.partial-1-folder/a.csv"), "a\n")
    assert not list(tmp_path.rglob(".checksums"))
    assert "holds no finished file" in tell_fault(code="E-FILE-MISSING")


def test_where_only_the_demo_was_made_it_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "demo").mkdir()
    monkeypatch.chdir(tmp_path / "demo")
    write_text(Path("results/tables/a.csv"), "a\n")
    monkeypatch.chdir(tmp_path)
    run()
    assert capsys.readouterr().err == "demo/results: 1 files with a checksum, 0 without\n"


def test_the_workflows_own_check_records_what_a_command_of_the_users_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("results/things.json")
    path.parent.mkdir()
    path.write_text('{"version": 1, "ground": null, "walls": 0, "things": []}\n')
    assert check(["things", str(path)]) == 0
    assert files.read_recorded(path) is None, "by hand: what is broken must not pass for whole"
    assert check(["--refuse", "things", str(path)]) == 0
    assert files.read_recorded(path) == files.digest_of(path)
    path.write_text("{}\n")
    assert check(["--refuse", "things", str(path)]) == 1
    assert not list(Path("results/.checksums").rglob("*.json"))


@pytest.mark.parametrize("content", [b"", b'{"shellc', b"\xff\xfe", b"[]", b'{"shellcmd": 7}', b"[" * 10**5])
def test_a_broken_file_of_snakemakes_is_told_and_the_rest_verified(
    folder: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    """As a power cut leaves them."""
    know(folder, TABLE)
    know(folder, "results/camera.json")
    broken = sorted(path for path in (folder / METADATA).rglob("*") if path.is_file())[0]
    broken.write_bytes(content)
    run()
    assert f"note: broken, so what made some files is not known; remove them: {broken.relative_to(folder)}\n" in (
        capsys.readouterr().err
    )
    flip(folder / TABLE)
    assert f"1 broken:\n  {TABLE}: differs" in tell_fault()


@pytest.mark.parametrize("name", ["x", "a b", "_w==", "\x1b[31m"])  # "_w==": of no text in UTF-8
def test_a_file_of_an_alien_name_is_told(folder: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    know(folder, TABLE)
    (folder / METADATA / name).write_text("{}")
    run()
    said = capsys.readouterr().err
    assert f"remove them: {METADATA / escape_control(name)}\n" in said and "\x1b" not in said


@pytest.mark.parametrize("line", ["truth 'results/a", "no_kind results/camera.json", "truth"])
def test_a_command_line_that_cannot_be_parsed_is_passed_over(folder: Path, line: str) -> None:
    """Names of files may hold what ends a check in a command line."""
    (record,) = folder.glob("results/.checksums/camera.json")
    record.unlink()
    know(folder, "results/a", f"(x && python -m roomkin.stages.contracts --refuse {line}) 2>&1")
    run()
    know(
        folder,
        "results/camera.json",
        "(x && python -m roomkin.stages.contracts --refuse truth results/camera.json) 2>&1",
    )
    assert "results/camera.json: results/camera.json: " in tell_fault()


def test_what_cannot_be_read_is_told_and_the_rest_verified(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder, a file, and a checksum, which then is none; this test may run as root, who reads everything."""
    flip(folder / TABLE)

    def refuse(path: str) -> NoReturn:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)

    scan, opened = os.scandir, Path.open
    closed = ["results/demos", "results/rgb.png", str(files.record_of(Path("results/camera.json")))]
    monkeypatch.setattr(os, "scandir", lambda path: refuse(path) if str(path) in closed else scan(path))
    monkeypatch.setattr(
        Path,
        "open",
        lambda path, *how, **more: refuse(str(path)) if str(path) in closed else opened(path, *how, **more),
    )
    said = tell_fault()
    assert "3 broken:" in said and f"{TABLE}: differs from its checksum" in said
    assert "results/demos: cannot be read (Permission denied)" in said
    assert "results/rgb.png: cannot be read (Permission denied)" in said
    assert files.read_recorded(Path("results/camera.json")) is None


def test_pipes_and_links_to_nowhere_are_passed_over(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo("results/pipe")
    Path("results/gone").symlink_to("nowhere")
    os.mkfifo("results/.checksums/odd.txt")
    Path("results/odd.txt").write_text("by hand")
    run()
    said = capsys.readouterr().err
    assert "6 files with a checksum, 1 without\n" in said and "go unseen: odd.txt\n" in said


def test_a_result_written_from_elsewhere_has_its_new_checksum(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also below a scene that is called results, by a path with .., and of a run inside results."""
    inside = folder / "results/scenes/results/view.json"
    write_json(inside, {})
    assert files.record_of(inside) == folder / "results/.checksums/scenes/results/view.json"
    monkeypatch.chdir(folder / "results/demos")
    write_text(Path("../evaluation/rollouts.csv"), "seed\n")
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    write_json(inside, {"a": 1})
    with atomic_folder(folder / "results/exports/lerobot") as out:
        (out / "info.json").write_text("{ }\n")
    write_text(Path("results/own.csv"), "a\n")
    run(results=folder / "results")
    run()

    monkeypatch.chdir(folder / "results/demos")
    write_text(Path("results/a.csv"), "a\n")
    assert files.read_recorded(Path("results/a.csv"), Path("results"))


def test_a_folder_called_results_that_no_run_wrote_gets_no_checksums(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "results/notes").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "results/notes")
    write_text(Path("a.csv"), "a\n")
    assert not list(tmp_path.rglob(".checksums"))


def damage(path: Path, how: str) -> None:
    """Other content; its time is kept."""
    status, content = path.stat(), path.read_bytes()
    if how == "flip":
        flip(path)
    else:
        path.write_bytes({"cut": content[:-1], "append": content + b"!", "empty": b""}[how])
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


@pytest.mark.parametrize("how", ["flip", "cut", "append", "empty"])
def test_what_was_damaged_is_told_before_a_run(folder: Path, capsys: pytest.CaptureFixture[str], how: str) -> None:
    os.utime(TABLE)
    warn_of_changed(list_for_run(Path("results")), Path("results"))
    assert capsys.readouterr().err == ""
    damage(Path(TABLE), how)
    warn_of_changed(list_for_run(Path("results")), Path("results"))
    said = capsys.readouterr().err
    assert said.startswith(f"warning: results: no longer what was written: {TABLE}. Fix: snakemake --cores 2 --force ")
    assert said.endswith("[E-RESULT-CHANGED]\n") and said.count("\n") == 1


def test_of_much_damage_a_few_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in list_files(Path("results"))[0]:
        damage(path, "append")
    warn_of_changed(list_for_run(Path("results")), Path("results"))
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and said.partition(" Fix: ")[0].count("results/") == NAMED and " and 3 more" in said


def test_before_a_run_the_largest_files_are_left_out(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = list_files(Path("results"))[0]
    monkeypatch.setattr(verify, "MOST", sum(sizes.values()) - 1)
    largest = max(sizes, key=lambda path: sizes[path])
    damage(largest, "flip")
    warn_of_changed(list_for_run(Path("results")), Path("results"))
    assert capsys.readouterr().err == ""
    assert str(largest) in tell_fault()
    damage(Path(TABLE), "flip")
    warn_of_changed(list_for_run(Path("results")), Path("results"))
    assert TABLE in capsys.readouterr().err


def test_what_is_made_anew_or_gone_is_not_told_again(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damage(Path(TABLE), "cut")
    damage(Path("results/camera.json"), "cut")
    changed = warn_of_changed(list_for_run(Path("results")), Path("results"))
    assert changed == [Path("results/camera.json"), Path(TABLE)] and capsys.readouterr().err
    write_text(Path(TABLE), "seed\n")
    Path("results/camera.json").unlink()
    assert warn_of_changed(changed, Path("results")) == [] and capsys.readouterr().err == ""
