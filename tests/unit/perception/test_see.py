"""Things, named and left out or placed, as an input folder."""

import json
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from benchmarks import real_frames
from roomkin.stages.config.perception import SeeSection
from roomkin.stages.config.weights import CLIP
from roomkin.stages.contracts import Camera, read_json, write_json
from roomkin.stages.contracts.scene_input import read_scene_input, write_scene_input
from roomkin.stages.contracts.things import Things, read_things
from roomkin.stages.perception import from_rgbd, see
from roomkin.stages.perception.classification import naming
from roomkin.stages.perception.classification.names import NO_KIND, NO_NAME, LikelyName, Names, find_reason
from roomkin.stages.perception.classification.naming import name_things
from roomkin.stages.perception.read.frame import Frame
from roomkin.stages.perception.see import caption_things
from roomkin.stages.perception.segmentation.choosing import Outlined
from roomkin.stages.perception.segmentation.proposal import Mask, RoomView
from tests.unit.perception.room_with_depth import ON_TABLE, TABLE, see_room

DATA = Path(os.environ.get("ACDC_TEST_DATA", Path(__file__).resolve().parents[4] / "shared/data"))
SURE = Names([LikelyName("mug", 0.9), LikelyName("jar", 0.05)], 0.05)
UNSURE = Names([LikelyName("desk", 0.4), LikelyName("bed", 0.3)], 0.3)
NONE = Names([LikelyName("desk", 0.3), LikelyName("table", 0.1)], 0.6)


def outlined(mask: Mask, flat: bool = False) -> Outlined:
    return Outlined(mask, 0.9, "test", {}, flat)


def name(
    monkeypatch: pytest.MonkeyPatch, view: RoomView, masks: list[Mask], *names: Names, flat: bool = False
) -> list[str]:
    """Why each thing is left out, if these are its names."""
    given = iter(names)
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: next(given))
    return [one.left_out for one in name_things(view, [outlined(mask, flat) for mask in masks], 0.5)]


def test_what_is_not_sure_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (_, mug) = see_room(TABLE, ON_TABLE)
    assert name(monkeypatch, view, [mug], SURE) == [""]
    assert name(monkeypatch, view, [mug], UNSURE) == [NO_NAME]
    assert name(monkeypatch, view, [mug], NONE) == [NO_KIND]


def test_what_carries_what_is_placed_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    assert name(monkeypatch, view, [table, mug], UNSURE, SURE) == ["", ""]
    assert name(monkeypatch, view, [table, mug], NONE, SURE) == ["", ""]
    assert name(monkeypatch, view, [table, mug], UNSURE, UNSURE) == [NO_NAME, NO_NAME]


def test_what_can_hardly_carry_is_not_placed_for_what_it_carries(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    cutlery = Names([LikelyName("cutlery", 0.02), LikelyName("table", 0.01)], 0.97)
    assert name(monkeypatch, view, [table, mug], cutlery, SURE) == [NO_KIND, ""]


def test_what_is_of_one_kin_is_sure_together(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (table, _) = see_room(TABLE, ON_TABLE)
    alike = Names([LikelyName("desk", 0.3), LikelyName("table", 0.25), LikelyName("bed", 0.1)], 0.35)
    assert name(monkeypatch, view, [table], alike) == [""]


def test_what_is_far_too_large_is_not_called_so(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    named = Names([LikelyName("mug", 0.6), LikelyName("desk", 0.35)], 0.05)
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: named)
    one, other = name_things(view, [outlined(table), outlined(mug)], 0.5)
    assert (one.names.proposals[0].name, other.names.proposals[0].name) == ("desk", "mug")


def test_what_nobody_can_place_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    lamp = ((2.0, -0.2, 1.9), (2.3, 0.2, 2.2))  # it hangs from the ceiling
    view, (mask,) = see_room(lamp)
    assert name(monkeypatch, view, [mask], SURE) == ["high above the ground, and no wall holds it"]
    view.depth[mask] = 0
    assert name(monkeypatch, view, [mask], SURE) == ["depth is known on 0 % of it alone"]


def test_what_is_flat_on_a_wall_is_called_so(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (picture,) = see_room(((3.96, -0.5, 1.2), (4.0, 0.3, 1.8)))
    names = Names([LikelyName("bed", 0.7), LikelyName("picture", 0.2), LikelyName("mirror", 0.05)], 0.05)
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: names)
    (one,) = name_things(view, [outlined(picture, flat=True)], 0.5)
    assert one.names.proposals[0].name == "picture" and one.names.proposals[0].probability > 0.6
    assert sum(each.probability for each in one.names.proposals) == pytest.approx(1)
    assert one.left_out == ""


def test_a_door_in_a_wall_is_no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (door,) = see_room(((3.97, -0.4, 0.0), (4.0, 0.4, 2.0)))
    (why,) = name(monkeypatch, view, [door], Names([LikelyName("picture", 0.9)], 0.1), flat=True)
    assert "door" in why


def test_what_is_flat_on_a_wall_is_placed_however_unsure_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (picture,) = see_room(((3.96, -0.5, 1.2), (4.0, 0.3, 1.8)))
    names = Names([LikelyName("radiator", 0.4), LikelyName("curtain", 0.3), LikelyName("picture", 0.2)], 0.1)
    assert find_reason(names, 0.5) == NO_NAME
    assert name(monkeypatch, view, [picture], names, flat=True) == [""]


def write_view(folder: Path, frame: Frame) -> None:
    camera = Camera(width=frame.rgb.shape[1], height=frame.rgb.shape[0], intrinsics=frame.intrinsics.tolist())
    write_scene_input(folder, frame.rgb, frame.depth, camera)


def test_an_input_folder_comes_out_and_things_left_out_keep_their_pixels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    write_view(tmp_path / "view", Frame(view.rgb, view.depth.astype(np.float32), view.intrinsics))
    monkeypatch.setattr(see, "list_proposals", lambda *_: [])
    monkeypatch.setattr(see, "choose", lambda *_: [outlined(mug), outlined(table)])
    given = iter([SURE, Names([LikelyName("bed", 0.2)], 0.8)])
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: next(given))
    monkeypatch.setattr(naming, "find_carriers", lambda *_: set())
    out = tmp_path / "seen in it"
    see.run(picture=tmp_path / "view", out=out)
    found = read_scene_input(out)
    (item,) = found.annotations.objects
    assert (item.label, item.proposals, item.probabilities) == ("mug", ["mug", "jar"], [0.9, 0.05])
    assert found.annotations.floor is not None and len(found.annotations.walls) == 1
    things = read_things(out)
    assert things is not None and [thing.left_out for thing in things.things] == ["", NO_KIND]
    assert ((found.masks == things.things[1].mask) == table).mean() > 0.999
    assert things.ground is not None and abs(things.ground.camera_height - 1.4) < 0.02
    assert things.ground.taken_from == "the lowest level surface"
    told = capsys.readouterr().out
    assert "1 thing, 1 more left out as unsure, 1 wall" in told and f"annotate '{out}'\n" in told


@pytest.mark.parametrize(("moved", "said"), [(0, False), (20, True)])
def test_depth_that_does_not_lie_on_what_the_picture_shows_is_doubted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moved: int, said: bool
) -> None:
    view, masks = see_room(TABLE, ON_TABLE)
    rgb = view.rgb.copy()
    for mask, color in zip(masks, (40, 220), strict=True):
        rgb[np.roll(mask, (moved, moved), (0, 1))] = color
    write_view(tmp_path / "view", Frame(rgb, view.depth.astype(np.float32), view.intrinsics))
    monkeypatch.setattr(see, "list_proposals", lambda *_: [])
    camera = read_json(Camera, tmp_path / "view/camera.json")
    write_json(tmp_path / "view/camera.json", camera.model_copy(update={"note": "said before"}))
    monkeypatch.setattr(see, "choose", lambda *_: [outlined(mask) for mask in masks])
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: SURE)
    see.run(picture=tmp_path / "view", out=tmp_path / "seen")
    note = read_json(Camera, tmp_path / "seen/camera.json").note
    assert note.startswith("said before") and ("depth in doubt" in note) == said


def test_where_no_thing_is_sure_the_surest_is_placed(monkeypatch: pytest.MonkeyPatch) -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    given = iter([UNSURE, Names([LikelyName("mug", 0.48), LikelyName("book", 0.42)], 0.1)])
    monkeypatch.setattr(naming, "observe", lambda *_: None)
    monkeypatch.setattr(naming, "propose_names", lambda *_: next(given))
    masks, things = see.label(see.Seen(view.surfaces, name_things(view, [outlined(table), outlined(mug)], 0.5)))
    assert [thing.left_out for thing in things.things] == [NO_NAME, ""]
    assert masks.labels[2] == "mug" and 1 not in masks.labels


def test_without_weights_our_own_network_proposes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: False)
    assert see.list_proposers(SeeSection()) == ["pieces"]
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda weights, _: weights is not CLIP)
    assert see.list_proposers(SeeSection()) == SeeSection().proposers, "CLIP outlines nothing"
    assert "make weights" in capsys.readouterr().out
    assert see.list_proposers(SeeSection(proposers=["pieces"])) == ["pieces"]


@pytest.fixture(scope="module")
def living(tmp_path_factory: pytest.TempPathFactory, published: None) -> Path:
    """A living room that a Kinect saw, as it is found."""
    frame = DATA / "rooms/living"
    if not frame.is_dir():
        pytest.skip(f"no {frame}: ACDC_TEST_DATA says where real data lie")
    out = tmp_path_factory.mktemp("living")
    options = {"rgb": frame / "color.png", "depth": frame / "depth.png", "camera": (str(frame / "camera.json"),)}
    from_rgbd.run(out=out / "view", **options)  # type: ignore[arg-type]
    see.run(picture=out / "view", out=out / "seen")
    return out / "seen"


def test_a_real_room_is_found(living: Path) -> None:
    """Eight of nine things that were outlined by hand, the floor within 3 cm, and the wall behind."""
    masks = cv2.imread(str(living / "masks.png"), cv2.IMREAD_UNCHANGED)
    drawn = cv2.imread(str(DATA / "rooms/living/masks.png"), cv2.IMREAD_UNCHANGED)
    drawn = drawn if drawn.ndim == 2 else drawn[..., 0]
    things = read_json(Things, living / "things.json")
    assert things.ground is not None and abs(things.ground.camera_height - 1.43) < 0.03
    assert things.walls == 1
    found = 0
    for item in json.loads((DATA / "rooms/living/annotations.json").read_text())["objects"]:
        thing = drawn == item["mask"]
        best = max(((masks == one.mask) & thing).sum() / ((masks == one.mask) | thing).sum() for one in things.things)
        found += best >= 0.5
    assert found >= 8


def test_what_stands_on_a_real_table_is_found(tmp_path: Path, published: None) -> None:
    """Nine things before a RealSense, whose outlines lie with the benchmark."""
    frames = DATA / "rgbd/uois_realsense_tabletop"
    if not frames.is_dir():
        pytest.skip(f"no {frames}: ACDC_TEST_DATA says where real data lie")
    files = {kind: frames / f"0000_{kind}.png" for kind in ("color", "depth")}
    lens = ("612.937", "613.173", "322.549", "248.158")
    from_rgbd.run(out=tmp_path / "view", rgb=files["color"], depth=files["depth"], camera=lens)
    see.run(picture=tmp_path / "view", out=tmp_path / "seen")
    masks = cv2.imread(str(tmp_path / "seen/masks.png"), cv2.IMREAD_UNCHANGED)
    drawn = cv2.imread(str(Path(real_frames.__path__[0]) / "0000.png"), cv2.IMREAD_UNCHANGED)
    shown = [masks == one.mask for one in read_json(Things, tmp_path / "seen/things.json").things]
    overlaps = [max((one & thing).sum() / (one | thing).sum() for one in shown) for thing in things_in(drawn)]
    assert len(overlaps) == 9 and min(overlaps) >= 0.5


def things_in(drawn: np.ndarray) -> list[Mask]:
    return [drawn == value for value in np.unique(drawn[drawn > 0])]


def test_a_real_room_is_the_same_every_time(living: Path, tmp_path: Path) -> None:
    see.run(picture=living.parent / "view", out=tmp_path / "again")
    for name_ in ("masks.png", "things.json", "depth.npz", "rgb.png"):
        assert (living / name_).read_bytes() == (tmp_path / "again" / name_).read_bytes()


def test_a_word_stays_if_it_was_asked_for_and_not_for_being_one_of_cocos(monkeypatch: pytest.MonkeyPatch) -> None:
    """COCO's network sees umbrellas, which no library here has, whether one asks for them or not."""
    view, (mask,) = see_room(TABLE)
    asked: list[object] = []
    monkeypatch.setattr(naming, "propose_names", lambda seen, words: asked.append(words) or NONE)
    called = {
        word: naming.decide(view, Outlined(mask, 0.9, "test", {word: 0.6}, False), 0.5)
        for word in ("umbrella", "couch", "pouffe")
    }
    assert called["umbrella"].left_out == called["couch"].left_out == NO_KIND
    assert called["pouffe"].names.proposals == [LikelyName("pouffe", 0.6)] and not called["pouffe"].left_out
    assert asked == [{"umbrella": 0.6}, {"couch": 0.6}]


def test_what_carries_is_rather_a_table_and_other_reasons_stay() -> None:
    _, (table, _) = see_room(TABLE, ON_TABLE)
    unsure = Names([LikelyName("bed", 0.4), LikelyName("table", 0.3)], 0.3)
    one = naming.Named(outlined(table), unsure, np.zeros(3), np.ones(3), NO_NAME)
    carrying = naming.carry(one)
    assert carrying.names.proposals[0].name == "table" and carrying.left_out == ""
    assert sum(each.probability for each in carrying.names.proposals) + carrying.names.other == pytest.approx(1)
    assert naming.carry(naming.replace(one, left_out="seen behind a wall")).left_out == "seen behind a wall"


def test_what_is_before_a_thing_does_not_carry_it() -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    carrier, carried = (
        naming.Named(outlined(mask), SURE, np.zeros(3), np.array([0, 0, top]))
        for mask, top in ((table, 0.72), (mug, 0.86))
    )
    assert naming.find_carriers(view, [carrier, carried]) == {1}
    assert naming.find_carriers(view, [carrier, replace(carried, left_out=NO_NAME)]) == set()
    view.surfaces.points[table, 2] -= 0.3
    assert naming.find_carriers(view, [carrier, carried]) == set()


def test_of_what_no_caption_knows_nobody_asks_how_it_is_held() -> None:
    view, masks = see_room(TABLE, ON_TABLE, ((2.2, 1.0, 0.0), (2.6, 1.4, 0.5)))
    said, held = {1: {"label": "table"}, 2: {}, 3: None}, list[int]()

    def hold(*asked: Any) -> tuple[int, list[int]]:
        held.append(asked[-1])
        return 2, []

    captioner: Any = SimpleNamespace(caption=lambda *asked: said[asked[-1]], hold=hold, summary=str)
    things = [naming.Named(outlined(mask), SURE, np.zeros(3), np.ones(3)) for mask in masks]
    found = caption_things(captioner, view, things, SeeSection(captions="vlm", mounting="vlm"))
    assert held == [1] and [one.stated for one in found] == [{"label": "table", "mounting": (2, [])}, {}, {}]
    assert [bool(one.left_out) for one in found] == [False, False, True]


def test_what_is_behind_a_wall_is_in_another_room_or_in_a_mirror(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = ((3.0, -4.0, 0.0), (3.1, -0.2, 3.0)), ((3.0, 0.2, 0.0), (3.1, 4.0, 3.0))
    view, (_, _, table) = see_room(*parts, ((3.9, -1.0, 0.0), (4.5, 1.0, 0.7)), wall=6.0)
    (why,) = name(monkeypatch, view, [table & view.surfaces.beyond], SURE)
    assert "behind a wall" in why
    glass = (np.abs(view.surfaces.points[..., 1]) < 0.4) & (view.surfaces.points[..., 2] > 1.0)
    monkeypatch.setattr(naming, "propose_names", lambda *_: Names([LikelyName("bed", 0.2)], 0.8))
    (one,) = name_things(view, [outlined(glass & view.surfaces.beyond, flat=True)], 0.5)
    assert one.names.proposals[0].name == "mirror"


def test_the_floor_below_a_table_top_that_is_the_ground_is_no_floor() -> None:
    view, (_, mug) = see_room(((0.3, -0.5, 0.7), (1.5, 0.5, 0.75)), ((0.9, -0.1, 0.75), (1.0, 0.0, 0.85)), wall=2.0)
    thing = naming.Named(outlined(mug), SURE, np.zeros(3), np.ones(3))
    masks, things = see.label(see.Seen(view.surfaces, [thing]))
    shown = masks.values == next(value for value, label in masks.labels.items() if label == "floor")
    assert shown.any() and view.surfaces.points[shown][:, 2].min() > -0.1
    assert things.ground is not None and "table top" in things.ground.taken_from
