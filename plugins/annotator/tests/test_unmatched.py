"""Masks are found anew: on the page and in the next run corrections go with their things, or are kept and told."""

import json
from pathlib import Path
from typing import Any

import cv2
import pytest

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_correcting import BOXES
from roomkin.stages.contracts import Annotations, Objects, read_json, write_json
from roomkin.stages.contracts.hand import CORRECTIONS, Correction, read_corrections
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.extract import run as extract
from roomkin.stages.generation.inputs import _match_corrections as match
from tests.unit.synthetic_room import FLOOR, OBJECT, WALL, write_room

CABINET, BOX, FOUND = OBJECT, OBJECT + 1, 30
LINE = f"'mug', found as 'box' (mask {BOX}): it is not found now: that correction is kept, not applied"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """What a person corrected before the cabinet got another number, another thing the cabinet's, and the box none."""
    folder = write_room(tmp_path / "kitchen", BOXES, ["cabinet", "box"])
    session = Correcting(folder)
    drawing = session.open_drawing().model_dump(mode="json")
    for item, label in zip(drawing["objects"], ["piano", "mug"], strict=False):
        item |= {"label": label, "named": True}
    session.save(drawing)
    masks = read_masks(folder / "masks.png")
    masks[masks == BOX] = FLOOR
    masks[masks == CABINET], masks[:40, :40] = FOUND, CABINET
    cv2.imwrite(str(folder / "masks.png"), masks)
    objects = [Annotation(mask=CABINET, label="clock"), Annotation(mask=FOUND, label="cabinet")]
    write_json(folder / "annotations.json", Annotations(objects=objects, floor=FLOOR, walls=[WALL]))
    return folder


def test_the_next_run_applies_what_is_found_and_tells_the_rest(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    extract(input=folder, scene="kitchen", out=tmp_path / "objects.json", corrections=(folder / CORRECTIONS,))
    found = read_json(Objects, tmp_path / "objects.json")
    assert {item.mask: item.label for item in found.objects} == {CABINET: "clock", FOUND: "piano"}
    assert found.lost == [LINE] and LINE in capsys.readouterr().out


def test_generation_moves_what_is_found_and_tells_the_rest(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / CORRECTIONS
    said = read_corrections([path])
    moved = [item.model_copy(update={"nudge": (0.1, 0.0)}) for item in said.objects]
    write_json(path, said.model_copy(update={"objects": moved}).as_document())
    assert match((path,), folder) == {FOUND: Correction(mask=FOUND, nudge=(0.1, 0.0))}
    assert f"box (mask {BOX}): it is not found now" in capsys.readouterr().out


def test_the_page_lists_what_is_not_found_until_it_is_forgotten(browser: Any, folder: Path) -> None:  # noqa: F811
    def read() -> list[str | None]:
        page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
        return [one.correction.label for one in read_corrections([folder / CORRECTIONS]).unmatched]

    session = Correcting(folder)
    assert json.dumps(session.start())
    with watched(browser, session, "#over polygon") as page:
        assert page.locator("#objects button").all_text_contents() == ["clock", "piano", "floor", "wall"]
        assert page.locator("#unmatched").is_visible() and LINE in page.locator("#unmatched li").all_text_contents()[0]
        page.locator("#objects button").first.click()
        page.fill("#label", "watch")
        page.keyboard.press("Enter")
        assert read() == ["mug"]
        page.reload()
        page.wait_for_selector("#over polygon")
        assert LINE in page.locator("#unmatched li").all_text_contents()[0]
        page.get_by_role("button", name="forget it").click()
        assert page.locator("#unmatched").is_hidden() and read() == []
        page.locator("#view").focus()
        page.keyboard.press("Control+z")
        assert page.locator("#unmatched").is_visible() and read() == ["mug"]
        told = {item.mask: item.label for item in read_corrections([folder / CORRECTIONS]).objects}
        assert told == {CABINET: "watch", FOUND: "piano"}
