"""Contract files: validated, atomic, and refused with one line when they break."""

import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from roomkin.stages.contracts import Camera, read_json, read_options, write_atomically, write_json
from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.files import digest_of
from roomkin.stages.contracts.hand import digest_of_picture
from roomkin.stages.contracts.policies import Attempt
from tests.refusals import refused

CAMERA = Camera(width=4, height=3, intrinsics=[[1, 0, 2], [0, 1, 1.5], [0, 0, 1]])


def test_round_trip_is_byte_for_byte(tmp_path: Path) -> None:
    write_json(tmp_path / "a.json", CAMERA)
    write_json(tmp_path / "b.json", read_json(Camera, tmp_path / "a.json"))
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


@pytest.mark.parametrize(
    ("text", "code", "field"),
    [
        ('{"version": 1, "width": 4, "height": 3}', "E-CONTRACT-BROKEN", "intrinsics"),
        (
            '{"version": 1, "width": 4, "height": 3, "intrinsics": [[1, 0, 2], [0, 1, 1], [0, 0, 1]], "fov": 1}',
            "E-CONTRACT-BROKEN",
            "fov",
        ),
        ('{"version": 1, "width": 4, "height": 3, "intrinsics": []}', "E-CONTRACT-BROKEN", "intrinsics"),
        ('{"version": 1, "width": 4.5, "height": 3, "intrinsics": []}', "E-CONTRACT-BROKEN", "width"),
        ('{"version": 1, "width": "4", "height": 3, "intrinsics": []}', "E-CONTRACT-BROKEN", "width"),
        ('{"width": 4, "height": 3}', "E-CONTRACT-VERSION", "version"),
        ('{"version": 2, "width": 4}', "E-CONTRACT-VERSION", "make it again"),
        ("not json", "E-CONTRACT-BROKEN", "JSON"),
    ],
)
def test_a_broken_file_names_itself_and_the_field(tmp_path: Path, text: str, code: str, field: str) -> None:
    path = tmp_path / "camera.json"
    path.write_text(text)
    with refused(code) as error:
        read_json(Camera, path)
    assert str(path) in str(error.value) and field in str(error.value)


def test_a_folder_shows_the_picture_that_it_was_made_of(tmp_path: Path) -> None:
    (tmp_path / "rgb.png").write_bytes(b"a picture")
    own = digest_of(tmp_path / "rgb.png")
    assert digest_of_picture(tmp_path) == own, "without camera.json, too"
    for digest, expected in (("", own), (64 * "a", 64 * "a")):
        write_json(tmp_path / "camera.json", CAMERA.model_copy(update={"digest": digest}))
        assert digest_of_picture(tmp_path) == expected


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with refused("E-FILE-MISSING"):
        read_json(Camera, tmp_path / "none.json")


def test_what_could_not_be_read_again_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValidationError, match="width"):
        write_json(tmp_path / "camera.json", CAMERA.model_copy(update={"width": -4}))
    assert not list(tmp_path.iterdir())


def test_a_failed_write_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "out.txt").write_text("old")
    with pytest.raises(RuntimeError), write_atomically(tmp_path / "out.txt") as path:
        path.write_text("half")
        raise RuntimeError
    assert (tmp_path / "out.txt").read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["out.txt"]


def test_options_accept_text_file_or_nothing(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(CAMERA.model_dump_json())
    assert read_options(Camera, str(tmp_path / "camera.json")) == CAMERA
    assert read_options(Camera, CAMERA.model_dump_json()) == CAMERA
    with refused("E-OPTIONS-INVALID"):
        read_options(Camera, "")


def test_checker_says_the_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "camera.json").write_text("not json")
    assert main(["--refuse", "camera", str(tmp_path / "camera.json")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.endswith(f"{tmp_path}/camera.json.refused [E-CONTRACT-BROKEN]\n")


def test_checker_checks_lines_and_tables(tmp_path: Path) -> None:
    good = Attempt(attempt=0, asset="a", seed=1, success=True, cause="success", steps=5, opened=0.5).model_dump_json()
    path = tmp_path / "attempts.jsonl"
    path.write_text(good + "\n")
    assert main(["attempts", str(path)]) == 0
    path.write_text(good + "\n{}\n")
    assert main(["attempts", str(path)]) == 1
    assert main(["nonsense", str(path)]) == 2
    assert main([]) == main(["attempts"]) == main(["attempts", "camera", str(path)]) == 2


def test_refused_files_are_kept_beside_their_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_json(tmp_path / "camera.json", CAMERA)
    (tmp_path / "annotations.json").write_text("{}")
    (tmp_path / "masks.png").write_bytes(b"a companion")
    files = ["annotations", str(tmp_path / "annotations.json")]
    assert main(files) == 1
    assert (tmp_path / "annotations.json").read_text() == "{}"
    assert main(["--refuse", *files]) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "annotations.json.refused", "camera.json", "masks.png.refused"
    ]  # fmt: skip
    line = capsys.readouterr().err.splitlines()[-1]
    assert "annotations.json: names no version" in line and "Kept as" in line and "annotations.json.refused" in line
    assert main(["--refuse", *files]) == 1  # nothing there: nothing to keep, still one line
    assert "no such file" in capsys.readouterr().err


def test_stage_command_lines_end_with_one_line(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "roomkin.stages.contracts", "camera", str(tmp_path / "none.json")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
