"""The page about one picture, on a small made-up run: what it says, what can be saved from it, how it looks."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.report import picture, report
from roomkin.plugins.report.page.single import color_depth
from roomkin.plugins.report.tests.test_report_browser import BROKEN, CONTRAST, WIDE, browser, cabinet_to_turn, unfold  # noqa: F401
from roomkin.plugins.report.tests.test_tables_report import Checker
from roomkin.stages.contracts import Camera, write_json
from tests.refusals import refused
from tests.unit.tables_results import CAMERA, VIEWER, declared, write_run

NOTE = "focal length 300 pixels, 44 degrees across: by EXIF"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page about room_1."""
    root = write_run(tmp_path_factory.mktemp("run"))
    results = root / "results"
    cabinet_to_turn(root, results / "generation/b/room_1")
    (results / "generation/b/room_1/scene_1.glb").write_bytes(b"glTF" * 100)
    depth = np.full((160, 240), 2.0, np.float32)
    depth[80:] = 4
    np.savez_compressed(results / "extraction/room_1/depth.npz", depth=depth)
    write_json(root / "camera.json", Camera(width=240, height=160, intrinsics=CAMERA, note=NOTE))
    page(root, "room_1", root / "room_1.html")
    return root


def page(root: Path, scene: str, out: Path, *others: str) -> None:
    files = [path for path in declared(root)["files"] if {scene, "snapshots", *others} & set(path.parts)]  # type: ignore[attr-defined]
    image = root / f"results/scenes/{scene}/input/rgb.png"
    picture.run(files=tuple(files), image=image, camera=root / "camera.json", scene=scene, out=out, viewer=VIEWER)


def test_it_tells_what_was_found_and_what_became_of_it(made: Path) -> None:
    text = (made / "room_1.html").read_text()
    checker = Checker()
    checker.feed(text)
    assert checker.open == [] and checker.unnamed == []
    assert {link[1:] for link in checker.links if link.startswith("#")} <= checker.ids
    assert not [one for one in (*checker.links, *checker.sources) if not one.startswith(("#", "data:", "results/"))]
    assert NOTE in text and "Distance: dark 2.0 m, bright 4.0 m" in text
    assert re.search(r"[0-9.]+ m above the floor, tilted (down|up) by \d+°", text)
    assert "vase 1" not in text and "vase_1 failed in extraction" in text
    assert "by geometry" in text and text.count('class="match"') >= 2 and "Rank 1:" in text


def test_every_doubt_has_the_command_that_opens_the_page_to_put_it_right(made: Path) -> None:
    text = (made / "room_1.html").read_text()
    opens = f"annotate {made}/results/scenes/room_1/input --scene room_1 --variant b --choose"
    section = text[text.index('<section id="doubts">') : text.index('<section id="found">')]
    doubts = re.findall(r'<li class="doubt"><b>(.*?)</b>: .*?(?:<code>(.*?)</code>|</li>)', section, re.DOTALL)
    assert len(doubts) > 1
    for about, command in doubts:
        if not about.startswith("scene of"):
            one = about.split(" failed in ")[0].replace(" ", "_")
            assert command == f"roomkin annotator {opens} {one}"


def test_the_log_counts_the_doubts_that_the_page_counts(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page(made, "room_1", made / "again.html")
    counted = re.search(r'<p class="root">(\d+ doubts? about \d+ things?)', (made / "again.html").read_text())
    assert counted and capsys.readouterr().out == f"{made / 'again.html'}: {counted[1]}\n"


def test_it_is_called_as_the_picture_that_went_in(made: Path, tmp_path: Path) -> None:
    camera = Camera(width=240, height=160, intrinsics=CAMERA, picture="Küche")
    write_json(tmp_path / "camera.json", camera)
    files = tuple(path for path in declared(made)["files"] if "room_1" in path.parts)  # type: ignore[attr-defined]
    image, out = made / "results/scenes/room_1/input/rgb.png", tmp_path / "page.html"
    picture.run(files=files, image=image, camera=tmp_path / "camera.json", scene="room_1", out=out)
    assert "<title>Küche</title>" in out.read_text() and "<h1>Küche</h1>" in out.read_text()
    assert "<h1>Room 1</h1>" in (made / "room_1.html").read_text()


def test_it_links_to_its_files(made: Path) -> None:
    links = re.findall(r'<li><a href="([^"]+)" download>', (made / "room_1.html").read_text())
    assert {Path(link).name for link in links} >= {"scene_1.glb", "scene_1.json", "objects.json", "cousins.json"}
    assert all((made / link).is_file() for link in links)


def test_it_is_about_one_picture(made: Path, tmp_path: Path) -> None:
    with refused("E-FILES-PICTURES"):
        page(made, "room_1", tmp_path / "page.html", "room_2")


def test_unknown_depth_is_black() -> None:
    depth = np.array([[0.0, 1.0, 3.0, 9.0]], np.float32)
    colors = color_depth(depth, 1.0, 3.0)
    assert not colors[0, 0].any() and (colors[0, 2] == colors[0, 3]).all() and colors[0, 3].sum() > colors[0, 1].sum()


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1300, "dark")])
def test_it_is_readable_and_nothing_overflows(made: Path, browser: Any, width: int, scheme: str) -> None:  # noqa: F811
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, offline=True)
    page, complaints = context.new_page(), []
    page.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto((made / "room_1.html").as_uri())
    unfold(page)
    page.wait_for_function("() => [...document.images].every((image) => image.complete)")
    assert page.evaluate("() => document.documentElement.scrollWidth") == width
    assert page.evaluate(WIDE) == [] and page.evaluate(BROKEN) == [] and page.evaluate(CONTRAST) == []
    assert complaints == []
    page.get_by_role("button", name="Turn the scene").click()
    page.wait_for_selector("#turntable[open] canvas")
    context.close()


def test_the_report_links_to_it_and_it_leads_back(made: Path, browser: Any) -> None:  # noqa: F811
    own, whole = made / "results/report/scenes/room_1.html", made / "results/report/index.html"
    page(made, "room_1", own)
    report.run(out=whole, **declared(made) | {"files": (*declared(made)["files"], own)})  # type: ignore[arg-type, misc]
    shown = browser.new_page()
    shown.goto(own.as_uri())
    assert not shown.locator("#back").is_visible()  # nobody led here
    shown.goto(whole.as_uri())
    links = shown.get_by_role("link", name="Its own page")
    assert links.count() == 1  # room_2 has none
    links.click()
    assert shown.url.startswith(own.as_uri())
    shown.locator("#back").click()
    assert shown.url == whole.as_uri()
    for elsewhere in ("javascript:alert(1)", "//a.html", "../a.html:b", "https://a.html"):
        shown.goto(f"{own.as_uri()}?from={elsewhere}")
        assert not shown.locator("#back").is_visible(), elsewhere
    shown.close()
