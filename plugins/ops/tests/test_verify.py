"""Finished results against what was recorded when they were written."""

import base64
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from plugins.ops.verify import METADATA, run
from stages.articulated.asset_folder import atomic_folder
from stages.contracts import checksums
from stages.contracts.__main__ import main as check
from stages.contracts.archives import pack
from stages.contracts.files import write_atomically, write_json, write_text
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
    know(folder, "results/camera.json", "(x && python -m stages.contracts --refuse truth results/camera.json) 2>&1")
    assert "results/camera.json: results/camera.json: " in tell_fault()


def test_the_same_files_have_the_same_record_and_a_new_file_a_new_one(folder: Path) -> None:
    before = checksums.read_recorded(Path(TABLE))
    write_text(Path(TABLE), "seed,success\n")
    assert checksums.read_recorded(Path(TABLE)) not in (None, before)
    write_text(Path(TABLE), "seed,success\n0,1\n1,0\n")
    assert checksums.read_recorded(Path(TABLE)) == before
    run()


def test_a_kill_before_the_record_leaves_none(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def killed(path: Path) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(checksums, "record", killed)
    with pytest.raises(KeyboardInterrupt):
        write_text(Path(TABLE), "seed\n")
    with pytest.raises(KeyboardInterrupt), atomic_folder(Path("results/exports/lerobot")) as out:
        (out / "info.json").write_text("{ }\n")
    assert checksums.read_recorded(Path(TABLE)) is None
    assert not Path("results/.checksums/exports/lerobot").exists()


def test_half_a_record_is_none(folder: Path) -> None:
    record = checksums.record_of(Path(TABLE))
    assert record
    record.write_text(record.read_text()[:30])
    assert checksums.read_recorded(Path(TABLE)) is None


def test_what_is_no_result_gets_no_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_text(Path("other/a.csv"), "a\n")
    write_text(Path("results/.partial-1-folder/a.csv"), "a\n")
    assert not list(tmp_path.rglob(".checksums"))
    assert "holds no finished file" in tell_fault(code="E-FILE-MISSING")


def test_the_workflows_own_check_records_what_a_command_of_the_users_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("results/things.json")
    path.parent.mkdir()
    path.write_text('{"version": 1, "ground": null, "walls": 0, "things": []}\n')
    assert check(["things", str(path)]) == 0
    assert checksums.read_recorded(path) is None, "by hand: what is broken must not pass for whole"
    assert check(["--refuse", "things", str(path)]) == 0
    assert checksums.read_recorded(path) == checksums.digest_of(path)
    path.write_text("{}\n")
    assert check(["--refuse", "things", str(path)]) == 1
    assert not list(Path("results/.checksums").rglob("*.json"))
