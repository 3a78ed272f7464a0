"""A click outlines a thing, names it and proposes its box: without a browser, then in one, on both pages."""

import json
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from roomkin.plugins.annotator import annotate, clicking
from roomkin.plugins.annotator.clicking import LACKING, Asked, Clicker
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.server import PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.seen_things import KnownClicker
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_by_hand import BOXES, HEIGHT, VIEW, WIDTH, _drawing, _pixels
from roomkin.plugins.annotator.tests.test_correcting import BOXES as ROOM
from roomkin.stages.contracts import Annotations, Objects, read_json
from roomkin.stages.contracts.hand import CORRECTIONS, PROJECT
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.masks import CORNERS, Mask, outline_mask, outline_pieces, polygon, polygons
from roomkin.stages.perception.camera.metrology import MetrologyError
from roomkin.stages.perception.classification.propose import LikelyName, Names
from roomkin.stages.perception.drawing import outlined
from roomkin.stages.perception.drawing.outlined import propose_box, weigh_names
from roomkin.stages.perception.drawing.project import DrawnObject, DrawnWall, Project, Scale
from roomkin.stages.perception.drawing.room import mark_box
from roomkin.stages.perception.drawing.solve import solve
from roomkin.stages.perception.read.photo import Photo
from roomkin.stages.perception.segmentation.ssd import DetectedBox
from tests.refusals import refused
from tests.unit.perception.conftest import published  # noqa: F401
from tests.unit.perception.test_networks import MIDDLE, draw_sign
from tests.unit.synthetic_room import OBJECT, write_room

PICTURE = np.full((HEIGHT, WIDTH, 3), 200, np.uint8)


def _square(x: int, y: int, side: int = 40) -> Mask:
    return polygon([(x, y), (x + side, y), (x + side, y + side), (x, y + side)], (HEIGHT, WIDTH))


THINGS = {"oven": _square(40, 140), "stool": _square(120, 140), "trash can": _square(220, 140)}


def _rings(mask: Mask) -> list[Any]:
    return outline_mask(mask)


def _same(one: Mask, other: Mask) -> bool:
    return bool((one ^ other).sum() < 0.02 * other.sum())


# what clicks outline


def test_a_click_outlines_the_whole_and_others_are_the_next_guesses() -> None:
    clicker = KnownClicker(PICTURE, THINGS)
    first, second, _ = clicker.outline(Asked(clicks=[(60, 160, True)]))
    assert _same(first, THINGS["oven"]) and 0.4 < second.sum() / first.sum() < 0.6
    assert clicker.outline(Asked(clicks=[(-5, 160, True)])) == []
    (boxed, *_) = clicker.outline(Asked(box=((165, 190), (35, 135))))
    assert _same(boxed, THINGS["oven"] | THINGS["stool"])


def test_of_two_things_that_hang_flat_beside_each_other_a_click_outlines_one() -> None:
    upper, lower, inside = _square(40, 40, 30), _square(40, 74, 30), _square(45, 45, 20)
    both, flat = _square(40, 40, 30) | _square(40, 74, 30), np.ones(PICTURE.shape[:2], bool)

    def first(part: Mask, other: Mask, whole: Mask, beyond: Mask | None) -> Mask:
        clicker, at = KnownClicker(PICTURE, THINGS), (50.0, 50.0)
        if beyond is not None:
            room: Any = SimpleNamespace(depth=np.ones(flat.shape), surfaces=SimpleNamespace(beyond=beyond))
            clicker.room = room
        clicker._guess = lambda point: [whole, part] if point == at else [other]  # type: ignore[method-assign]
        return clicker.outline(Asked(clicks=[(*at, True)]))[0]

    assert _same(first(upper, lower, both, flat), upper)
    assert _same(first(upper, lower, both, None), both), "nobody knows how far away it is: doors of a cupboard?"
    assert _same(first(upper, lower, both, ~flat), both), "it stands out of the wall"
    assert _same(first(inside, upper & ~inside, upper, flat), upper), "a picture and its frame"


def test_what_a_detector_found_comes_first_unless_a_thing_lies_on_it() -> None:
    table, candle, leg = _square(100, 100, 100), _square(140, 110, 10), _square(100, 150, 40)
    clicker = KnownClicker(PICTURE, {"table": table})
    clicker.found = [table]
    for parts, first in (
        ([candle, _square(140, 110, 11), table], candle),
        ([leg, _square(100, 150, 10), table], table),
    ):
        clicker.guesses = parts
        assert _same(clicker.outline(Asked(clicks=[(145.0, 155.0, True)]))[0], first)
    clicker.guesses = [candle, leg, leg]
    assert not _same(clicker.outline(Asked(clicks=[(145.0, 155.0, True)]))[0], table), "no guess is like what was found"


def test_a_second_click_adds_and_one_with_shift_takes_away() -> None:
    clicker, both = KnownClicker(PICTURE, THINGS), THINGS["oven"] | THINGS["stool"]
    clicks = [(60, 160, True), (140, 160, True)]
    assert _same(clicker.outline(Asked(clicks=clicks, before=_rings(THINGS["oven"])))[0], both)
    after = Asked(clicks=clicks[1:], before=_rings(THINGS["oven"]))  # of the first nothing is known any more
    assert _same(clicker.outline(after)[0], both)
    taken = clicker.outline(Asked(clicks=[(140, 160, False)], before=_rings(both)))
    assert _same(taken[0], THINGS["oven"])
    assert clicker.outline(Asked(clicks=[(140, 160, False)])) == [], "there is nothing to take from"
    whole = clicker.outline(Asked(clicks=[(60, 160, False)], before=_rings(THINGS["oven"])))
    assert all(0 < mask.sum() <= THINGS["oven"].sum() for mask in whole), "something is left"


def test_a_guess_at_several_clicks_is_good_and_heeds_each_of_them() -> None:
    clicker, both = KnownClicker(PICTURE, THINGS), THINGS["oven"] | THINGS["stool"]
    asked = Asked(clicks=[(60, 160, True), (140, 160, True)], before=_rings(THINGS["oven"]))
    by_the_last_click_alone = 3
    for best, taken in ((both, 1), (THINGS["oven"], 0)):
        clicker.guesses = [best, both, both]  # the others are no good ones
        assert len(clicker.outline(asked)) == taken + by_the_last_click_alone


def test_a_box_of_the_network_names_the_outline_that_it_agrees_with(monkeypatch: pytest.MonkeyPatch) -> None:
    clicker = KnownClicker(PICTURE, THINGS)
    clicker.boxes = [DetectedBox((40, 140, 80, 180), "oven", 0.9, {"oven": 0.9})]
    monkeypatch.setattr(clicking, "observe_looks", lambda *_: None)
    monkeypatch.setattr(clicking, "propose_names", lambda _, words: words)
    for mask, words in ((THINGS["oven"], {"oven": 0.9}), (_square(40, 140, 100), None), (THINGS["stool"], None)):
        assert Clicker.name(clicker, mask) == words


def test_the_networks_outline_a_sign_by_a_click_and_by_a_box(published: None) -> None:  # noqa: F811
    rgb, truth = draw_sign()
    clicker = Clicker(rgb)
    x, y, width, height = cv2.boundingRect(truth.astype(np.uint8))
    for asked in (Asked(clicks=[(*MIDDLE, True)]), Asked(box=((x, y), (x + width, y + height)))):
        best = max(clicking.overlap(mask, truth) for mask in clicker.outline(asked))
        assert best > 0.9
    pole = [(300.0, 300.0, True)]
    sign = clicker.outline(Asked(clicks=[(*MIDDLE, True)]))[0]
    both = clicker.outline(Asked(clicks=[(*MIDDLE, True), *pole], before=_rings(sign)))[0]
    assert both[300, 300] and (both & sign).sum() > 0.9 * sign.sum()
    names = clicker.name(truth)
    assert sum(one.probability for one in names.proposals) + names.other == pytest.approx(1)


def test_without_weights_nothing_is_offered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(clicking, "list_lacking", lambda: ["clip"])
    session = Session(Photo(PICTURE, None, 1.0), "a.jpg", tmp_path)
    session.begin_looking()
    assert capsys.readouterr().out.strip() == LACKING and "make weights" in LACKING
    assert session.start()["clicks"] is False and session.ready() == {"ready": False}
    with refused("E-WEIGHTS-MISSING", "make weights"):
        session.outline({"clicks": [[60, 160, True]]})


def test_what_is_no_request_is_refused_and_clicks_far_outside_do_no_harm(tmp_path: Path) -> None:
    session = Session(Photo(PICTURE, None, 1.0), "a.jpg", tmp_path)
    session.clicker = KnownClicker(PICTURE, THINGS)
    for body in ({}, {"clicks": []}, {"clicks": [[0, 0]]}, {"clicks": [[1e9, 0, True]]}, {"clicks": [[0, 0, 1]] * 200}):
        with pytest.raises(ValueError):
            session.outline(body)
    far = {"clicks": [[5000, 5000, True], [60, 160, True]], "before": _rings(THINGS["oven"])}
    assert session.outline(far)["guesses"]


def test_pieces_and_names_are_told_to_the_page(tmp_path: Path) -> None:
    session = Session(Photo(PICTURE, None, 1.0), "a.jpg", tmp_path)
    session.clicker = KnownClicker(PICTURE, {"bench": THINGS["oven"] | THINGS["trash can"]})
    guess = session.outline({"clicks": [[60, 160, True]]})["guesses"][0]
    assert len(guess) == 2 and _same(polygons(guess, (HEIGHT, WIDTH)), session.clicker.things["bench"])
    asked = {"project": session.start()["project"], "outlines": guess, "on": "auto"}
    named = session.names(asked)
    assert (named["names"][0], named["label"], named["opens"]) == ("bench", "bench", False)
    assert session.names(asked | {"outlines": []})["names"] == []


# the box of an outline


def _hull(box: UprightBox) -> list[Any]:
    return [cv2.convexHull(np.array(_pixels(corners(box)), np.float32))[:, 0].tolist()]


def _placed(drawing: Project, name: str, label: str, on: str = "auto") -> UprightBox:
    on, points = propose_box(drawing, solve(drawing), _hull(BOXES[name]), on, label)
    drawing.objects.append(DrawnObject(id=name, label=label, on=on, points=points, outline=_hull(BOXES[name])[0]))
    return solve(drawing).boxes[name]


def test_a_box_is_proposed_where_an_outline_says_that_it_is() -> None:
    left, right = _pixels([[-1, 3.5, 0], [1, 3.5, 0]])
    drawing = _drawing(objects=[], walls=[DrawnWall(id="back", a=left, b=right)])
    for name, label, near in (("cabinet", "", 0.05), ("mug", "mug", 0.06), ("shelf", "", 0.12)):
        found, true = _placed(drawing, name, label), BOXES[name]
        assert np.linalg.norm(found.center - true.center) < near * np.linalg.norm(true.center), name
        sides = [0, 1, 2] if name == "cabinet" else [0, 2]  # small ones tell little of their depth
        assert np.abs(np.log(found.size[sides] / true.size[sides])).max() < 0.35, name
    assert [item.on for item in drawing.objects] == ["floor", "cabinet", "back"]


def test_a_thing_that_is_cut_is_placed_by_its_usual_size() -> None:
    """Its feet are below the picture: without a name it is taken to be as deep as anything."""
    true = UprightBox([0.3, 1.8, 0.37], [1.2, 0.8, 0.74], 0.0)
    hull = cv2.convexHull(np.array(_pixels(corners(true)), np.float32))[:, 0]
    seen = polygon(hull, (HEIGHT, WIDTH))
    assert hull[:, 1].max() > HEIGHT + 50 and seen[-1].any()
    drawing, errors = _drawing(objects=[], walls=[]), {}
    for label in ("", "table"):
        on, points = propose_box(drawing, solve(drawing), outline_mask(seen), "auto", label)
        placed = _drawing(objects=[DrawnObject(id="table", label=label, on=on, points=points)], walls=[])
        errors[label] = np.abs(np.log(solve(placed).boxes["table"].size / true.size)).max()
    assert errors["table"] < 0.1 and errors[""] > 0.2


def test_what_was_drawn_before_a_thing_may_cut_its_outline_but_what_carries_it_does_not() -> None:
    """A nightstand half behind the cabinet is as wide as usual; a box on the cabinet ends where it is seen to."""
    drawing = _drawing(objects=_drawing().objects[:1])
    (cabinet,), (outline,) = drawing.objects, _hull(BOXES["cabinet"])
    cabinet.outline = outline
    before = polygons([outline], (HEIGHT, WIDTH))
    for name, on, true in (
        ("nightstand", "floor", UprightBox([-0.15, 4.0, 0.26], [0.45, 0.42, 0.52], 0.0)),
        ("", "cabinet", UprightBox([-0.5, 3.1, 1.0], [0.2, 0.2, 0.2], 0.0)),
    ):
        shown = polygons(_hull(true), before.shape) & ~(before & (on == "floor"))
        on, points = propose_box(drawing, solve(drawing), outline_mask(shown), on, name)
        thing = DrawnObject(id="it", label=name, on=on, points=points)
        assert solve(drawing.model_copy(update={"objects": [cabinet, thing]})).boxes["it"].size[
            [0, 2]
        ] == pytest.approx(true.size[[0, 2]], rel=0.1), name


def test_names_are_weighed_by_size_and_by_what_holds_the_thing() -> None:
    names = Names([LikelyName("wardrobe", 0.4), LikelyName("wall cabinet", 0.2), LikelyName("nightstand", 0.2)], 0.2)
    stands, hangs = weigh_names(names, False, 0.5, 0.6), weigh_names(names, True, 0.6, 0.7)
    assert stands.proposals[0].name == "nightstand" and hangs.proposals[0].name == "wall cabinet"
    assert sum(one.probability for one in stands.proposals) + stands.other == pytest.approx(1)
    bed = weigh_names(Names([LikelyName("bed", 0.5), LikelyName("picture", 0.3)], 0.2), True, 1.5, 0.8)
    assert bed.proposals[0].name == "picture", "no bed hangs"


def test_a_rear_corner_is_marked_where_an_outline_tells_the_depth() -> None:
    box = UprightBox([-0.9, 3.0, 0.2], [0.8, 1.0, 0.4], 0.0)
    assert [len(mark_box(VIEW, box, False, told)) for told in (False, True)] == [3, 4]
    assert len(mark_box(VIEW, box, True)) == 2, "a wall tells where the rear is"
    assert len(mark_box(VIEW, BOXES["cabinet"], False)) == 3, "hidden by its front"
    with pytest.raises(MetrologyError, match="behind the camera"):
        mark_box(VIEW, UprightBox([0, 0, 0.2], [1, 1, 0.4], 0.0), False)


def test_what_fits_nowhere_keeps_its_bounds_as_marks(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> object:
        raise np.linalg.LinAlgError("SVD did not converge")

    drawing = _drawing(objects=[], walls=[], scale=Scale(metres=1.5))
    monkeypatch.setattr(outlined, "fit_standing", fail)
    (hull,) = _hull(BOXES["cabinet"])
    (x0, y0), (x1, y1) = np.min(hull, axis=0), np.max(hull, axis=0)
    marks = propose_box(drawing, solve(drawing), [hull], "floor", "")[1]
    assert np.array(marks) == pytest.approx(np.array([(x0, y1), (x1, y1), ((x0 + x1) / 2, y0)]))


def test_what_no_level_carries_keeps_its_bounds_as_marks() -> None:
    drawing = _drawing(objects=[], walls=[], scale=Scale(metres=1.5))
    sky = [[(10.0, 5.0), (40.0, 5.0), (40.0, 20.0), (10.0, 20.0)]]
    on, points = propose_box(drawing, solve(drawing), sky, "auto", "clock")
    assert on == "floor" and points == [(10, 20), (40, 20), (25, 5)]


# on the page of a photograph


@pytest.fixture
def drawn(browser: Any, tmp_path: Path) -> Iterator[tuple[Any, Session]]:  # noqa: F811
    session = Session(Photo(PICTURE, VIEW.focal, 1.0), "a.jpg", tmp_path / "a", ["oven", "stool"])
    session.clicker = KnownClicker(PICTURE, THINGS)
    with watched(browser, session, "#grid") as page:
        page.wait_for_function("() => document.getElementById('clicking').textContent === 'Click (C)'")
        page.keyboard.press("c")
        yield page, session


def test_without_weights_the_page_is_as_it_was(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    with watched(browser, Session(Photo(PICTURE, None, 1.0), "a.jpg", tmp_path), "#grid") as page:
        page.keyboard.press("3")
        hint = page.locator("#hint").text_content()
        page.keyboard.press("c")
        assert page.locator("#clicking").is_hidden() and page.locator("#hint").text_content() == hint
        page.keyboard.press("b")
        assert page.locator("#by-clicks").is_hidden() and page.locator("#hint").text_content() != hint


def _click(page: Any, x: float, y: float, to: tuple[float, float] | None = None) -> None:
    """A click at a pixel, or a box from there to another, once the page has shown and saved what comes of it."""
    a, d, e, f = page.locator("#view").evaluate("e => { const m = e.getScreenCTM(); return [m.a, m.d, m.e, m.f]; }")
    page.evaluate("() => { document.getElementById('saved').textContent = 'not yet'; }")
    page.mouse.move(x * a + e, y * d + f)
    page.mouse.down()
    if to:
        page.mouse.move(to[0] * a + e, to[1] * d + f, steps=3)
    page.mouse.up()
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")


def _project(session: Session) -> Project:
    return read_json(Project, session.folder / PROJECT)


def _shown(item: Any) -> Mask:
    return polygons(item.outlines, (HEIGHT, WIDTH))


def test_a_photograph_is_drawn_by_clicks(drawn: tuple[Any, Session]) -> None:
    page, session = drawn
    _click(page, 60, 160)
    (item,) = _project(session).objects
    assert _same(_shown(item), THINGS["oven"]) and (item.label, item.articulated) == ("oven", True)
    assert len(item.points) >= 3 and item.on == "floor"
    assert page.locator("#view .click").count() == 1 and page.locator("#view .outline").count() == 1
    page.locator("#view").focus()
    page.evaluate("() => { document.getElementById('saved').textContent = 'not yet'; }")
    page.keyboard.press("g")
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    assert _shown(_project(session).objects[0]).sum() < 0.6 * THINGS["oven"].sum()
    _click(page, 140, 160)  # what more belongs to it
    (item,) = _project(session).objects
    assert len(item.pieces) == 1 and _shown(item)[160, 140]
    page.keyboard.down("Shift")
    _click(page, 140, 160)
    page.keyboard.up("Shift")
    assert not _shown(_project(session).objects[0])[160, 140]
    page.locator("#label").focus()  # its name is right
    page.keyboard.press("Enter")
    _click(page, 215, 135, (265, 185))  # the next thing, by a box around it
    assert [one.label for one in _project(session).objects] == ["oven", "trash can"]
    page.keyboard.press("Control+z")
    page.wait_for_function("() => document.querySelectorAll('#objects button').length === 1")


def test_a_name_ends_a_thing_and_moves_its_box_until_a_person_has_moved_that(
    drawn: tuple[Any, Session], monkeypatch: pytest.MonkeyPatch
) -> None:
    page, session = drawn
    monkeypatch.setattr(clicking, "SURE", 1.0)  # no name is
    cut = {
        "oven": _square(40, 205),
        "stool": _square(120, 140),
        "trash can": _square(220, 140),
    }  # by the picture's edge
    session.clicker = KnownClicker(PICTURE, cut)
    _click(page, 60, 220)
    before = _project(session).objects[0]
    assert before.label == "" and page.locator("#proposals button").first.text_content() == "oven"
    page.evaluate("() => { document.getElementById('saved').textContent = 'not yet'; }")
    page.locator("#proposals button").first.click()
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    page.wait_for_timeout(400)
    after = _project(session).objects[0]
    assert after.label == "oven" and after.points != before.points
    _click(page, 140, 160)
    assert len(_project(session).objects) == 2, "the first has its name: this is the next one"
    page.locator("#objects button").first.click()
    page.get_by_role("button", name="Outline by clicks").click()
    _click(page, 240, 160)
    first, second = _project(session).objects
    assert _shown(first)[160, 240] and first.points == after.points and first.label == "oven"
    assert not _shown(second)[160, 240]


# on the page of a frame with depth


def _bare(folder: Path) -> dict[str, Mask]:
    """A room of a cabinet and a box, as a frame without masks; where the things are."""
    write_room(folder, ROOM, ["cabinet", "box"])
    masks = read_scene_input(folder).masks
    for name in ("masks.png", "annotations.json"):
        (folder / name).unlink()
    return {"cabinet": masks == OBJECT, "box": masks == OBJECT + 1}


def test_a_frame_without_masks_says_so_until_they_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _bare(tmp_path / "frame")
    monkeypatch.setattr(clicking, "list_lacking", lambda: ["clip"])
    monkeypatch.setattr(PageServer, "serve_forever", lambda self, poll_interval: None)
    annotate.run(tmp_path / "frame", results=tmp_path, browser=False)
    said = capsys.readouterr().out
    assert LACKING in said and said.rstrip().endswith("no masks yet: open it again, and end it with Done")


def test_a_frame_without_masks_gets_them_by_clicks(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    folder = tmp_path / "frame"
    things = _bare(folder)
    session = Correcting(folder, [], tmp_path / "results", "frame")
    assert [item.label for item in session.open_drawing().objects] == ["floor", "wall"]
    session.clicker = KnownClicker(session.rgb, things)
    with watched(browser, session, "#over polygon") as page:
        page.wait_for_function("() => document.getElementById('clicking').textContent === 'Click (C)'")
        page.keyboard.press("c")
        for mask in things.values():
            rows, columns = np.nonzero(mask)
            _click(page, float(np.median(columns)), float(np.median(rows)))
            page.keyboard.press("Enter")
        told = json.loads((folder / CORRECTIONS).read_text())["objects"]
        assert [item["label"] for item in told] == ["cabinet", "box"] and len(told[0]["outline"]) > 3
        assert not (folder / "annotations.json").exists()
        page.get_by_role("button", name="Check it").click()
        page.wait_for_selector("#written:not([hidden])")
        assert page.locator("#ids").text_content() == "cabinet_1, box_1"
    given = read_scene_input(folder)
    assert [item.label for item in given.annotations.objects] == ["cabinet", "box"]
    assert given.annotations.floor is not None and len(given.annotations.walls) == 1
    assert read_json(Annotations, folder / "annotations.json").objects[0].articulated
    for item in given.annotations.objects:
        assert clicking.overlap(given.masks == item.mask, things[item.label]) > 0.95
    assert "max_tilt" in (folder / "config.yaml").read_text()
    extract(input=folder, scene="frame", out=tmp_path / "out" / "objects.json")
    found = read_json(Objects, tmp_path / "out" / "objects.json").objects
    assert all(item.box is not None for item in found)
    again = Correcting(folder, [], tmp_path / "results", "frame").open_drawing()
    assert [item.label for item in again.objects] == ["cabinet", "box", "floor", "wall"]


def test_an_outline_has_no_more_corners_than_a_drawing_keeps() -> None:
    angles, grid = np.linspace(0, 2 * np.pi, 3000, endpoint=False), np.zeros((2000, 2000), np.uint8)
    reach = 700 + 200 * (np.arange(3000) % 2)
    star = np.stack([1000 + reach * np.cos(angles), 1000 + reach * np.sin(angles)], axis=1)
    cv2.fillPoly(grid, [np.rint(star).astype(np.int32)], 1)
    rings = outline_pieces(grid > 0)
    assert max(map(len, outline_mask(grid > 0))) > CORNERS >= len(rings[0]) > CORNERS / 2
