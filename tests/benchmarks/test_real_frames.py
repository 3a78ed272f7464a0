"""The nine real frames: masks and names that were said by hand agree, and a frame is scored by them."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.open_rooms.run import StoppedError
from benchmarks.real_frames import __main__ as frames
from benchmarks.real_frames.__main__ import HERE, NAMES, FrameThing, count, score_frame
from roomkin.stages.contracts import Annotations, Cousins, Objects, write_json
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.cousins import Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.contracts.things import Name, Thing, Things


def test_every_mask_has_a_name_that_the_library_knows() -> None:
    assert sum(map(len, NAMES.values())) == 33
    for frame, names in NAMES.items():
        masks = cv2.imread(str(HERE / f"{frame}.png"), cv2.IMREAD_UNCHANGED)
        assert set(np.unique(masks)) == {0, *map(int, names)}
        assert {one for each in names.values() for one in each} <= set(known_categories())


def test_a_frame_is_scored_by_its_pieces_names_and_cousins(tmp_path: Path) -> None:
    """Of the two mugs of a frame one is found, second among its names, and a jar stands for it."""
    masks = cv2.imread(str(HERE / "0007.png"), cv2.IMREAD_UNCHANGED).astype(np.uint16)
    found = np.where(masks == 2, 9, 0).astype(np.uint16)
    (tmp_path / "input").mkdir()
    cv2.imwrite(str(tmp_path / "input/masks.png"), found)
    item = Annotation(mask=9, label="jar", proposals=["jar", "mug", "box"])
    write_json(tmp_path / "input/annotations.json", Annotations(objects=[item]))
    names = [Name(name=name, probability=share) for name, share in (("jar", 0.6), ("mug", 0.2), ("box", 0.1))]
    thing = Thing(mask=9, names=names, other=0.1, score=0.9, source="ssd")
    write_json(tmp_path / "input/things.json", Things(walls=0, things=[thing]))
    height, width = found.shape
    eye = [[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]
    view = {"scene": "a", "width": width, "height": height, "intrinsics": [[600, 0, 320], [0, 600, 240], [0, 0, 1]]}
    box = Box(center=(1, 0, 0.1), size=(0.1, 0.1, 0.2), yaw=0)
    known = SceneObject(id="jar_1", label="jar", mask=9, box=box, mounting=Mounting(type=2), pixels=(0, 0, 9, 9))
    write_json(tmp_path / "objects.json", Objects(**view, floor_from_camera=eye, walls=[], objects=[known]))
    turned = Orientation(yaw=0, distance=0)
    cousin = Cousin(
        rank=1, asset="jar_1", category="jar", distance=0, votes=None, orientation=turned, orientations=[turned]
    )
    matched = ObjectCousins(id="jar_1", label="jar", by_distance=[], cousins=[cousin])
    write_json(tmp_path / "geometry/cousins.json", Cousins(scene="a", encoder="hog", objects=[matched]))
    things, pieces = score_frame("0007", tmp_path)
    assert things == [FrameThing(shown=True, three=True, placed=True), FrameThing()] and pieces == 1
    assert count(things) == ["1 / 2", "0 / 2", "1 / 2", "1 / 2", "0 / 2"]
    write_json(
        tmp_path / "input/things.json", Things(walls=0, things=[thing.model_copy(update={"left_out": "unsure"})])
    )
    assert score_frame("0007", tmp_path)[0][0] == FrameThing(shown=True, three=True)
    (tmp_path / "input/things.json").unlink()  # as where somebody outlined and named it
    assert score_frame("0007", tmp_path) == ([FrameThing(shown=True, placed=True), FrameThing()], 1)


@pytest.mark.parametrize(
    "given, steps", [("depth", ["rgbd", "see"]), ("outlines", ["rgbd 0000.png"]), ("nothing", ["draw"])]
)
def test_a_frame_is_read_by_what_is_given(
    given: str, steps: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []

    def read(masks: Path | None = None, **said: object) -> None:
        assert (said.get("depth"), said["rgb"]) == (tmp_path / "0000_depth.png", tmp_path / "0000_color.png")
        done.append("rgbd" + (f" {masks.name}" if masks else ""))

    monkeypatch.setattr(frames.from_rgbd, "run", read)
    monkeypatch.setattr(frames.see, "run", lambda **_: done.append("see"))
    monkeypatch.setattr(frames.draw, "run", lambda **_: done.append("draw"))
    frames.write_input(given, tmp_path / "0000_color.png", tmp_path, tmp_path / "input")
    assert done == steps
    assert (tmp_path / "labels.json").is_file() == (given == "outlines")


def test_a_frame_that_stops_is_told_and_counts_as_not_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object) -> None:
        raise StoppedError("no object has a place yet")

    (tmp_path / "0000_color.png").touch()
    monkeypatch.setattr(frames, "reconstruct", stop)
    monkeypatch.setattr(frames, "shelves", lambda *_: None)
    monkeypatch.setattr("sys.argv", ["real_frames", str(tmp_path), str(tmp_path / "out")])
    frames.main()
    printed = capsys.readouterr()
    assert "0000: no object has a place yet" in printed.err
    assert "| 0000 | 0 | 0 / 9 |" in printed.out and "0 of 0 scenes stand" in printed.out
