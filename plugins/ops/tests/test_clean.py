"""`make clean` deletes what runs wrote, and nothing that a person made."""

import json
import shutil
from pathlib import Path

import pytest

from roomkin.plugins.ops.clean import run
from tests.refusals import refused

BY_HAND, FOUND = json.dumps({"version": 1, "objects": []}), json.dumps({"untouched": True})


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_results_go_and_hand_work_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    kept = write(tmp_path / "hand/kitchen/corrections.json", BY_HAND)
    write(tmp_path / "results/scenes/kitchen/frame/corrections.json", "{")  # of an older version, and broken
    kept.rename(tmp_path / "elsewhere")
    write(tmp_path / "results/photo/bath/project.json", BY_HAND)
    write(tmp_path / "results/photo/found/project.json", FOUND)
    write(tmp_path / "demo/results/scenes/living/input/corrections.json", BY_HAND)
    gone = [write(tmp_path / name, "") for name in (
        "results/tables/table2.csv", "logs/a.log", ".snakemake/metadata/x", "benchmarks/scenes/see.tsv", "demo/logs/b",
        "results/.checksums/photo/bath/project.json",
    )]  # fmt: skip
    program = write(tmp_path / "benchmarks/rooms/run.py", "")
    run()
    assert not any(path.exists() for path in (*gone, tmp_path / "results", tmp_path / "demo/results"))
    assert program.exists() and kept.read_text() == "{"
    assert (tmp_path / "hand/bath/project.json").read_text() == BY_HAND
    assert (tmp_path / "demo/hand/living/corrections.json").read_text() == BY_HAND
    assert not (tmp_path / "hand/found").exists(), "what networks drew is a result"
    said = capsys.readouterr().err
    assert "results/photo/bath/project.json: moved to hand/bath/project.json" in said
    assert said.splitlines()[-1] == (
        "deleted results/ (3 files), logs/ (1 file), .snakemake/ (1 file), benchmarks/scenes/see.tsv, demo/results/ "
        "(0 files), demo/logs/ (1 file); kept hand, demo/hand"
    )
    run()
    assert kept.exists() and capsys.readouterr().err == "deleted nothing; kept hand, demo/hand\n"


@pytest.mark.parametrize("name", ["mine/corrections.json", "photo/a/corrections.json"])
def test_nothing_is_deleted_where_hand_work_has_no_other_place(tmp_path: Path, name: str) -> None:
    write(tmp_path / "hand/a/corrections.json", BY_HAND)  # its place is taken
    mine, result = write(tmp_path / "results" / name, BY_HAND), write(tmp_path / "results/table.csv", "")
    with refused("E-HAND-WORK", str(mine)):
        run(folder=tmp_path)
    hidden = shutil.copytree(tmp_path, tmp_path / ".hidden/project")
    with refused("E-HAND-WORK"):
        run(folder=hidden)
    assert result.exists() and mine.read_text() == BY_HAND
