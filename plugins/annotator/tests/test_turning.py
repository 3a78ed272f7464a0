"""One picture, two pages: the drawing of a photograph, and what was made of it; one command serves both."""

import re
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from roomkin.plugins.annotator import annotate
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.server import HERE, PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.plugins.annotator.tests.annotate_page import watched
from roomkin.plugins.annotator.tests.test_annotate_browser import browser  # noqa: F401
from roomkin.plugins.annotator.tests.test_by_hand import _drawing, _noise
from roomkin.stages.contracts import read_json
from roomkin.stages.contracts.hand import PROJECT
from roomkin.stages.perception.drawing.project import Project
from tests.refusals import refused

# What is the same on both pages: everything else is a key of one of them alone.
ON_BOTH = {"c", "o", "g", "n", "p", "Enter", "Escape", "Backspace", "Delete"}


@pytest.fixture
def drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Session:
    """A photograph with a drawing that is not written yet."""
    monkeypatch.chdir(tmp_path)
    Image.fromarray(_noise()).save("a.png")
    session = annotate._open_photograph(Path("a.png"), None, None, None, None, None)
    session.save(_drawing().model_dump(mode="json"))
    return session


def _scene_of(session: Session) -> Any:
    return partial(annotate._open_scene, session.folder, ["mug"], Path("results"))


def test_a_key_of_both_pages_does_the_same_on_both() -> None:
    found = []
    for script in ("tools.js", "correct.js"):
        text = (HERE / script).read_text(encoding="utf-8")
        tools = re.search(r"const TOOLS = \{(.*?)\}", text)
        found.append({*re.findall(r"key === '(\w+)'", text), *re.findall(r"(\w+):", tools[1] if tools else "")})
    assert found[0] & found[1] == ON_BOTH


def test_each_page_says_what_it_is_for_and_leads_to_the_other(browser: Any, drawn: Session) -> None:  # noqa: F811
    drawn.write(_drawing().model_dump(mode="json"))
    with watched(browser, drawn, "#grid", _scene_of(drawn)) as page:
        assert "For a photograph without depth" in page.locator("#about").inner_text()
        page.locator("#objects button", has_text="mug").click()
        page.evaluate(
            "() => { const label = document.getElementById('label'); label.value = 'vase';"
            " label.dispatchEvent(new Event('change')); document.getElementById('other').click(); }"
        )  # before what is said can have been saved
        page.wait_for_selector("#view .region")
        assert "For what was found and made" in page.locator("#about").inner_text()
        assert read_json(Project, drawn.folder / PROJECT).objects[1].label == "vase", "what was typed is kept"
        page.locator("#other").click()
        page.wait_for_selector("#grid")
        page.locator("#objects button", has_text="vase").wait_for()


def test_a_scene_is_shown_as_it_was_written_meanwhile(drawn: Session) -> None:
    server = PageServer(drawn, other=_scene_of(drawn))
    with refused("E-SCENE-EMPTY", "a: has no scene yet. Fix: make scenes of it, first"):
        server.turn()
    assert server.session is drawn
    drawn.write(_drawing().model_dump(mode="json"))
    server.turn()
    made = server.session
    assert isinstance(made, Correcting) and len(made.found) == 5
    server.turn()
    assert server.session is drawn
    drawn.write(_drawing(objects=_drawing().objects[:1]).model_dump(mode="json"))
    server.turn()
    assert server.session is made and len(made.found) == 3
    server.server_close()


def test_what_has_depth_has_one_page(drawn: Session) -> None:
    drawn.write(_drawing().model_dump(mode="json"))
    server = PageServer(Correcting(drawn.folder))
    assert server.open_page()["other"] is False
    with refused("E-OPTION-CONFLICT", "the other page"):
        server.turn()
    server.server_close()
