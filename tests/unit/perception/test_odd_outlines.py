"""One odd outline never ends a picture: it is left out with its reason, and what is beside it is placed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from roomkin.stages.config.perception import SeeSection
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.geometry.masks import Mask
from roomkin.stages.perception import draw, see
from roomkin.stages.perception.classification import naming
from roomkin.stages.perception.classification.names import UNMEASURED
from roomkin.stages.perception.layout.fit import Layout
from roomkin.stages.perception.layout.room import arrange, build_room
from roomkin.stages.perception.layout.things import HANGS, RESTS, STANDS
from roomkin.stages.perception.read.frame import Frame
from roomkin.stages.perception.segmentation.choosing import Outlined
from tests.unit.perception.room_alone import LABELS, outline_room, see_lines, show_room
from tests.unit.perception.room_with_depth import see_room
from tests.unit.perception.test_naming import known, unknown

TABLE, BESIDE = ((1.6, -0.6, 0.0), (2.0, 0.3, 0.6)), ((1.8, -0.3, 0.6), (2.0, 0.1, 1.0))


def make_odd(shape: tuple[int, ...]) -> dict[str, Mask]:
    """No pixel, one, a row, a column, a corner, specks, two corners."""
    found = {
        name: np.zeros(shape, bool) for name in ("nothing", "pixel", "row", "column", "corner", "specks", "corners")
    }
    height, width = shape
    found["pixel"][height // 2, width // 2] = True
    found["row"][height // 2], found["column"][:, width // 2] = True, True
    found["corner"][-1, -1] = True
    found["specks"][::17, ::13] = True
    found["corners"][:2, :2], found["corners"][-2:, -2:] = True, True
    return found


def see_beside(monkeypatch: pytest.MonkeyPatch, folder: Path, odd: Mask, flat: bool, where: str) -> see.Seen:
    """A table, which is sure, and an odd outline, as an input folder."""
    view, (table, _) = see_room(TABLE, BESIDE)
    if where == "behind its wall":
        shown = [wall & ~odd for wall in view.surfaces.wall_masks]
        view = replace(view, surfaces=replace(view.surfaces, beyond=view.surfaces.beyond | odd, wall_masks=shown))
    if where == "without depth":
        view = replace(view, depth=np.where(odd, 0, view.depth))
    things = [Outlined(table & ~odd, 0.9, "ssd", {"dining table": 0.95}, False)]
    things.append(Outlined(odd, 0.9, "mobile_sam", {}, flat))
    monkeypatch.setattr(
        "roomkin.stages.perception.classification.propose.load_tower", lambda: None
    )  # these looks say nothing
    monkeypatch.setattr(see, "look", lambda *_: view)
    monkeypatch.setattr(see, "list_proposals", lambda *_: [])
    monkeypatch.setattr(see, "choose", lambda *_: things)
    frame = Frame(view.rgb, view.depth.astype(np.float32), view.intrinsics)
    seen = see.see(frame, SeeSection(sure=0.0))
    see.write_seen(folder / "seen", frame, seen)
    return seen


@pytest.mark.parametrize("where", ["in the room", "behind its wall", "without depth"])
@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("kind", ["nothing", "pixel", "row", "column", "corner", "specks", "corners"])
def test_with_depth(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: str, flat: bool, where: str) -> None:
    shape = see_room(TABLE, BESIDE)[0].depth.shape
    _, odd = see_beside(monkeypatch, tmp_path, make_odd(shape)[kind], flat, where).things
    assert len(read_scene_input(tmp_path / "seen").annotations.objects) == 1 + (not odd.left_out)
    if kind == "nothing":
        assert odd.left_out == UNMEASURED
    elif where != "in the room":
        assert "depth is known on" in odd.left_out or "behind a wall" in odd.left_out
    extract(input=tmp_path / "seen", scene="seen", out=tmp_path / "found/objects.json")


def test_what_fails_for_one_thing_leaves_that_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    observe = naming.observe

    def fail(rgb: object, depth: object, mask: Mask, *rest: object) -> object:
        if mask.sum() < 5:
            raise IndexError("index -1 is out of bounds")
        return observe(rgb, depth, mask, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(naming, "observe", fail)
    shape = see_room(TABLE, BESIDE)[0].depth.shape
    pixels = np.zeros(shape, bool)
    pixels[shape[0] // 2, shape[1] // 2 :][:3] = True
    table, odd = see_beside(monkeypatch, tmp_path, pixels, False, "in the room").things
    assert (table.left_out, odd.left_out) == ("", UNMEASURED)
    assert "index" not in (tmp_path / "seen/things.json").read_text()


@pytest.mark.parametrize(("kind", "shows"), [("pixel", "mug"), ("row", STANDS), ("corner", HANGS), ("specks", RESTS)])
def test_without_depth(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: str, shows: str) -> None:
    masks = outline_room((1, 3))
    odd = make_odd(masks.shape)[kind]
    seen = [known((masks == value) & ~odd, (LABELS[value], 0.9)) for value in (1, 3)]
    seen.append(known(odd, (shows, 0.9)) if shows == "mug" else unknown(odd, shows))
    monkeypatch.setattr(draw, "see_outlines", lambda *_: seen)
    monkeypatch.setattr(draw, "see_camera", lambda *_: see_lines())
    picture = show_room()
    picture[::2] += 60  # it shows something
    Image.fromarray(picture).save(tmp_path / "room.png")
    draw.run(image=tmp_path / "room.png", out=tmp_path / "room")
    labels = [item.label for item in read_scene_input(tmp_path / "room").annotations.objects]
    assert "fridge" in labels and "coffee table" in labels


def test_what_fits_nowhere_is_left_out_of_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    masks, place = outline_room((1, 3, 4)), Layout.place

    def fail(layout: Layout, camera: object) -> object:
        if (layout.at[:, 0] > -200).any():  # the fridge, which is to the left
            raise np.linalg.LinAlgError("SVD did not converge")
        return place(layout, camera)  # type: ignore[arg-type]

    monkeypatch.setattr(Layout, "place", fail)
    labels = {value: LABELS[value] for value in (1, 3, 4)}
    arranged = arrange(see_lines(), masks, labels, np.ones(masks.shape, bool))
    (odd,) = arranged.odd
    assert (odd, arranged.values) == (1, [3, 4])
    assert arranged.boxes[4].bottom == pytest.approx(arranged.boxes[3].top), "the mug stays on its table"
    room = build_room(show_room(), arranged, masks)
    assert room.left_out[odd] == UNMEASURED and odd not in room.boxes
    monkeypatch.setattr(Layout, "place", lambda *_: 1 / 0)
    assert arrange(see_lines(), masks, labels, np.ones(masks.shape, bool)).odd == {1, 3, 4}


def test_a_fit_that_fails_for_no_single_thing_is_no_endless_search(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> object:
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(Layout, "improve", fail)
    with pytest.raises(np.linalg.LinAlgError):
        arrange(see_lines(), masks := outline_room((1, 3)), {1: LABELS[1], 3: LABELS[3]}, np.ones(masks.shape, bool))


def test_where_no_name_is_sure_the_surest_is_drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    masks = outline_room((1, 3))
    likely = {1: (("fridge", 0.5), ("wardrobe", 0.4)), 3: (("coffee table", 0.5), ("desk", 0.4))}
    seen = [known(masks == value, *names) for value, names in likely.items()]
    monkeypatch.setattr(draw, "see_outlines", lambda *_: seen)
    monkeypatch.setattr(draw, "see_camera", lambda *_: see_lines())
    picture = show_room()
    picture[::2] += 60  # it shows something
    Image.fromarray(picture).save(tmp_path / "room.png")
    draw.run(image=tmp_path / "room.png", out=tmp_path / "room", options='{"sure": 1.0}')
    assert len(read_scene_input(tmp_path / "room").annotations.objects) == 1
