"""Where a person's work on a picture lies: in hand/, or in the picture's own folder; and which picture it is of."""

import json
from pathlib import Path

import pytest

from roomkin.stages.contracts import Camera, read_json, write_json
from roomkin.stages.contracts.hand import (
    CORRECTIONS,
    PROJECT,
    Correction,
    Corrections,
    command_for,
    digest_of_image,
    digest_of_picture,
    find_hand_file,
    hand_folder,
    is_by_hand,
    read_corrections,
)
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.contracts.matched import match_corrections
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.read.photo import read_photo
from tests.unit.synthetic_room import OBJECT, write_room

BOXES = [UprightBox((3.7, -0.8, 0.4), (0.6, 0.8, 0.8), 0.0), UprightBox((2.5, 0.6, 0.3), (0.5, 0.5, 0.6), 0.3)]
OURS, THEIRS = "a" * 64, "b" * 64


@pytest.mark.parametrize(("folder", "place"), [
    ("results/photo/kitchen", "hand/kitchen"), ("results/scenes/кухня/frame", "hand/кухня"),
    ("results/scenes/room_1/input", "hand/room_1"), ("results/scenes/a/view", "hand/a"),
    ("./results/scenes/../photo/a/", "hand/a"), ("/x/demo/results/photo/a", "/x/demo/hand/a"),
    ("/results/photo/a", "/hand/a"), ("results/demo/results/photo/a", "results/demo/hand/a"),
    ("my/kitchen", "my/kitchen"), ("my/results/kitchen", "my/results/kitchen"), ("results/photo", "results/photo"),
    ("results/scenes/a/other", "results/scenes/a/other"), ("results/photo/a/b", "results/photo/a/b"),
])  # fmt: skip
def test_what_is_done_to_a_result_stands_beside_results(folder: str, place: str) -> None:
    assert hand_folder(Path(folder)) == Path(place)


def test_what_the_workflow_made_is_put_right_by_its_scenes_name() -> None:
    assert command_for(Path("results/photo/a_1")) == "roomkin correct a_1"
    assert command_for(Path("my kitchen")) == "roomkin annotator annotate 'my kitchen'"


def test_a_path_from_inside_results_leads_to_the_same_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "results/photo/a").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "results/photo")
    assert hand_folder(Path("a")) == tmp_path / "hand/a"


@pytest.mark.parametrize("name", [CORRECTIONS, PROJECT])
def test_each_picture_finds_its_own(tmp_path: Path, name: str) -> None:
    def find(digest: str) -> Path:
        return find_hand_file(tmp_path, name, lambda: digest)

    assert find(OURS) == tmp_path / name
    (tmp_path / name).write_text(json.dumps({"version": 1, "digest": OURS}))
    assert find(OURS) == tmp_path / name
    assert find(THEIRS) == tmp_path / name.replace(".json", f".{THEIRS[:8]}.json")
    assert find("") == tmp_path / name, "the picture is yet to be made: the stage that reads both compares"
    (tmp_path / name).write_text(json.dumps({"version": 1}))
    assert find(THEIRS) == tmp_path / name, "nothing says that it is not"
    (tmp_path / name).write_text("{")
    assert find(THEIRS) == tmp_path / name, "its reader says what is wrong with it"


def test_no_picture_is_read_where_nothing_is_kept(tmp_path: Path) -> None:
    def refuse() -> str:
        raise AssertionError

    assert find_hand_file(tmp_path, PROJECT, refuse) == tmp_path / PROJECT


def test_work_of_an_older_version_is_moved_once_and_a_result_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = Path("results/photo/kitchen")
    folder.mkdir(parents=True)
    (folder / PROJECT).write_text(json.dumps({"untouched": True}))
    assert find_hand_file(folder, PROJECT, str) == Path("hand/kitchen", PROJECT)
    assert not is_by_hand(folder / PROJECT) and not Path("hand").exists() and capsys.readouterr().err == ""
    (folder / PROJECT).write_text("drawn")
    path = find_hand_file(folder, PROJECT, str)
    assert path.read_text() == "drawn" and not (folder / PROJECT).exists()
    assert f"{folder / PROJECT}: moved to {path}" in capsys.readouterr().err
    (folder / PROJECT).write_text("again")
    assert find_hand_file(folder, PROJECT, str).read_text() == "drawn" and (folder / PROJECT).read_text() == "again"
    assert f"{folder / PROJECT}: not used: {path} is" in capsys.readouterr().err


def test_corrections_of_an_older_version_learn_what_their_numbers_mean(tmp_path: Path) -> None:
    """The masks that they were made on lie beside them, until the next run finds them anew."""
    folder = write_room(tmp_path / "results/scenes/kitchen/frame", BOXES, ["cabinet", "box"])
    write_json(folder / CORRECTIONS, {"version": 1, "objects": [{"mask": OBJECT, "label": "piano"}]})
    path = find_hand_file(folder, CORRECTIONS, lambda: OURS)
    assert path == tmp_path / "hand/kitchen" / CORRECTIONS
    said, masks = read_corrections([path]), read_masks(folder / "masks.png")
    assert [one.label for one in said.shown] == ["cabinet"] and said.objects == [Correction(mask=OBJECT, label="piano")]
    swapped = masks.copy()
    swapped[masks == OBJECT], swapped[masks == OBJECT + 1] = OBJECT + 1, OBJECT
    assert match_corrections(said, swapped, OURS).corrections == {
        OBJECT + 1: Correction(mask=OBJECT + 1, label="piano")
    }


def test_what_knows_its_masks_keeps_them_when_it_is_moved(tmp_path: Path) -> None:
    folder = write_room(tmp_path / "results/scenes/kitchen/frame", BOXES, ["cabinet", "box"])
    said = Corrections(masks=THEIRS, objects=[Correction(mask=OBJECT, label="piano")])
    write_json(folder / CORRECTIONS, said.as_document())
    assert read_corrections([find_hand_file(folder, CORRECTIONS, lambda: OURS)]) == said


def test_a_picture_is_the_file_that_it_was_read_from(tmp_path: Path) -> None:
    folder = write_room(tmp_path, BOXES, ["cabinet", "box"])
    camera = read_json(Camera, folder / "camera.json")
    own = digest_of_picture(folder)
    (folder / "rgb.png").write_bytes((folder / "rgb.png").read_bytes() + b"\0")
    assert digest_of_picture(folder) != own
    write_json(folder / "camera.json", camera.model_copy(update={"digest": OURS}))
    assert (
        digest_of_picture(folder)
        == OURS
        == digest_of_image(folder / "rgb.png")
        == read_photo(folder / "rgb.png").digest
    )
    (folder / "rgb.png").rename(folder / "color.png")
    assert digest_of_image(folder / "color.png") != OURS, "a camera.json beside a picture of yours may be another's"
