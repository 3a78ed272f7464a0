"""The command: from a submission to rows, a line and a page; and what it says of mistakes."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from roomkin.plugins.scorecard import baselines, score
from roomkin.plugins.scorecard.tests.rooms import CABINET, HEAD, MUG, TABLE, room, say, write_rooms
from tests.refusals import refused


def write(path: Path, **rooms: Any) -> Path:
    """A submission in one file."""
    path.write_text(json.dumps(HEAD | {"rooms": rooms}))
    return path


def test_a_submission_becomes_rows_a_line_and_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write_rooms(tmp_path / "rooms")
    mine = write(tmp_path / "mine.json", toy_room_1=room(say(TABLE), say(MUG), say(CABINET, name="sofa")))
    score.run(mine, rooms="toy", data=data, out=tmp_path / "out")
    said = capsys.readouterr().out
    assert "| mine | depth | 1 of 1 | 3 | 100 [" in said and "| 67 [" in said
    rows = pd.read_csv(tmp_path / "out/things.csv")
    assert rows["sensible"].tolist() == [True, True, False] and (tmp_path / "out/row.md").read_text() in said
    page = (tmp_path / "out/index.html").read_text()
    assert "toy_room_1" in page and "cupboard is a sofa" in page and str(tmp_path) not in page
    assert said.splitlines()[-1] == f"Open {tmp_path / 'out/index.html'}"
    first = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    score.run(mine, rooms="toy", data=data, out=tmp_path / "again")
    assert first == {path.name: path.read_bytes() for path in (tmp_path / "again").iterdir()}


@pytest.mark.parametrize(
    ("bad", "told"),
    [
        ({"frame": "floor", "things": []}, "floor_from_camera: goes with the frame 'floor'"),
        (room(say(TABLE, size=[800, 1400, 800])), "is no extent in metres"),
        (room(say(TABLE, support="7")), "'7' is no other thing's place"),
        (room(say(TABLE, support="0")), "'0' is no other thing's place"),
        (room(*[say(TABLE)] * 301), "at most 300 items"),
        (room(say(TABLE, number=1), say(MUG, number=1)), "two have the same number"),
        (room(say(TABLE, colour="red")), "things.0.colour"),
        ("a chair", "(top level)"),
    ],
)
def test_a_room_that_cannot_be_read_is_told_and_missed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], bad: Any, told: str
) -> None:
    data = write_rooms(tmp_path / "rooms")
    score.run(write(tmp_path / "a.json", toy_room_1=bad), rooms="toy", data=data, out=tmp_path, pictures=False)
    assert "toy_room_1: not read, all of it counts as missed: " in (said := capsys.readouterr().out) and told in said
    assert set(pd.read_csv(tmp_path / "things.csv")["status"]) == {"unread"}


def test_a_room_that_is_not_there_is_missed_and_strange_rooms_are_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = write_rooms(tmp_path / "rooms")
    score.run(write(tmp_path / "a.json", other=3), rooms="toy", data=data, out=tmp_path)
    assert "not in the submission, all of them count as missed: toy_room_1" in capsys.readouterr().out
    assert set(pd.read_csv(tmp_path / "things.csv")["status"]) == {"missed"}


@pytest.mark.parametrize(("given", "placed"), [(["depth"], False), (["depth", "exact masks"], True)])
def test_a_number_counts_only_where_masks_were_given(tmp_path: Path, given: list[str], placed: bool) -> None:
    data = write_rooms(tmp_path / "rooms")
    far = say(MUG, number=2, center=[3.5, 3.5, 0.05])
    mine = tmp_path / "a.json"
    mine.write_text(json.dumps(HEAD | {"given": given, "rooms": {"toy_room_1": room(far)}}))
    score.run(mine, rooms="toy", data=data, out=tmp_path, pictures=False)
    rows = pd.read_csv(tmp_path / "things.csv").set_index("label")
    assert rows.loc["cup", "placed"] == placed


def test_a_method_s_name_stays_in_its_cell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write_rooms(tmp_path / "rooms")
    mine = write(tmp_path / "mine.json", toy_room_1=room(say(TABLE)))
    mine.write_text(mine.read_text().replace('"mine"', '"a|<b>\\nc"'))
    score.run(mine, rooms="toy", data=data, out=tmp_path / "out", pictures=False)
    assert "| a/(b) c | depth |" in capsys.readouterr().out


def test_two_submissions_are_compared_thing_by_thing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write_rooms(tmp_path / "rooms")
    whole = write(tmp_path / "a.json", toy_room_1=room(say(TABLE), say(MUG), say(CABINET)))
    part = write(tmp_path / "b.json", toy_room_1=room(say(TABLE)))
    score.run(whole, rooms="toy", data=data, out=tmp_path, against=part, pictures=False)
    assert "| placed | +67 [" in capsys.readouterr().out


def test_mistakes_of_the_whole_are_refused(tmp_path: Path) -> None:
    data = write_rooms(tmp_path / "rooms")
    mine = write(tmp_path / "mine.json")
    with refused("E-WORDS", "has no set 'toi'. Fix: did you mean 'toy'?"):
        score.run(mine, rooms="toi", data=data)
    with refused("E-FILE-MISSING", "python -m benchmarks.open_rooms make DIR"):
        score.run(mine, rooms="toy", data=tmp_path / "none")
    with refused("E-FILE-MISSING", "did you mean"):
        score.run(tmp_path / "mine.jsn", rooms="toy", data=data)
    silent = tmp_path / "silent.json"
    silent.write_text(json.dumps({key: value for key, value in HEAD.items() if key != "seen"} | {"rooms": {}}))
    with refused("E-CONTRACT-BROKEN", "seen: Field required"):
        score.run(silent, rooms="toy", data=data)
    (data / "toy/toy_room_1/truth.json").write_text("{}")
    with refused("E-CONTRACT-BROKEN", "is no truth of a room"):
        score.run(mine, rooms="toy", data=data)


def test_baselines_are_submissions(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write_rooms(tmp_path / "rooms")
    baselines.run(rooms="toy", data=data, out=tmp_path / "made")
    for name in baselines.ABOUT:
        score.run(tmp_path / f"made/{name}.json", rooms="toy", data=data, out=tmp_path / name, pictures=False)
    assert "not read" not in capsys.readouterr().out
    moved = pd.read_csv(tmp_path / "truth_moved/things.csv")
    assert moved["place"].all() and (moved["off_place_cm"] == 5.0).all()
    assert pd.read_csv(tmp_path / "usual_boxes/things.csv")["placed"].tolist() == [True, True, True]
    assert not pd.read_csv(tmp_path / "other_room/things.csv")["placed"].any()  # there is no other


def test_scoring_imports_nothing_that_making_needs() -> None:
    script = "import sys, roomkin.plugins.scorecard.score\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    assert not {"mitsuba", "open3d", "torch", "sapien", "benchmarks"} & set(loaded)
