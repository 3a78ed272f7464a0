"""The report page in headless Chromium: nothing overflows, toggles work by keyboard, colors keep their contrast."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.pictures import glb
from roomkin.plugins.report import report
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.objects import Mounting, Wall
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.scene_file import room_of
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import look_at
from roomkin.stages.tables import policies, scenes
from tests.unit.demo_assets import cabinet
from tests.unit.tables_results import VIEWER, declared, write_run

PUBLISHED = Path(__file__).resolve().parents[3] / "report" / "published"
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
FLAGS += ["--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
WIDE = """
() => [...document.querySelectorAll('main *, header *')]
  .filter((e) => e.checkVisibility() && !e.closest('.scroll, pre') && e.getBoundingClientRect().right > innerWidth + 1)
  .map((e) => e.outerHTML.slice(0, 80))
"""
BROKEN = """
() => [...document.images].filter((i) => i.getAttribute('src') !== 'data:,' && (!i.naturalWidth || !i.alt))
  .map((i) => i.outerHTML.slice(0, 80))
"""
CONTRAST = """
() => {
  const canvas = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const rgb = (color) => { canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = color; canvas.fillRect(0, 0, 1, 1);
                            return [...canvas.getImageData(0, 0, 1, 1).data]; };
  const linear = (value) => value <= 10.31475 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const behind = (element) => {
    for (let node = element; node; node = node.parentElement) {
      const color = rgb(getComputedStyle(node).backgroundColor);
      if (color[3] === 255) return color;
    }
    return rgb('white');
  };
  const low = [];
  for (const element of document.querySelectorAll('p, a, li, small, span, b, th, td, h1, h2, h3, h4, h5, summary,'
                                                  + ' button, figcaption, legend, label, svg text')) {
    if (!element.checkVisibility() || ![...element.childNodes].some((n) => n.nodeType === 3 && n.data.trim())) continue;
    const style = getComputedStyle(element);
    const drawn = element.closest('svg') ? style.fill : style.color;
    const [a, b] = [light(rgb(drawn)), light(behind(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < (element.closest('svg') ? 3 : 4.5)) {
      low.push(`${element.tagName} ${element.textContent.trim().slice(0, 30)} ${ratio.toFixed(2)}`);
    }
  }
  return low;
}
"""


def cabinet_to_turn(folder: Path, out: Path) -> None:
    """The scenes of room_1: a red cabinet with a door, on a floor and at a wall."""
    asset = cabinet(folder / "cabinet")
    made = read_json(GeneratedScene, out / "scene_1.json")
    made.walls = [Wall(id="wall_1", normal=(-1, 0, 0), offset=-3.0, points=99)]
    made.floor_from_camera = look_at([0, 0, 1.2], [3, 0, 0.4]).tolist()
    box = UprightBox((2.7, 0, asset.size[2] / 2), asset.size, np.pi)
    item = Placed("cabinet_1", "cabinet", asset, folder / "cabinet", box, Mounting(type=3))
    for rank in (1, 2):
        glb.write(room_of(made, [item], None), out / f"view_{rank}.glb", 128)


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The page of a small run."""
    root = write_run(tmp_path_factory.mktemp("browser"))
    results = root / "results"
    cabinet_to_turn(root, results / "generation/default/room_1")
    scores = tuple(sorted(results.glob("evaluation/scenes/default/*/scores.csv")))
    scenes.run(out=results / "tables", figures=results / "figures", scores=scores, published=PUBLISHED)
    rollouts = tuple(sorted(results.glob("evaluation/policies/*/rollouts.csv")))
    out = {"out": results / "tables", "figures": results / "figures"}
    policies.run(**out, rollouts=rollouts, more=("roomkin.plugins.claims.more",), published=PUBLISHED)
    viewer = Path(shutil.copy(VIEWER, root))
    report.run(out=root / "index.html", published=PUBLISHED, viewer=viewer, **declared(root))  # type: ignore[arg-type]
    return (root / "index.html").as_uri()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, as `make test` installs it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("no Chromium: the report page is not looked at (bash envs/chromium.sh, as root on Debian)")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=found, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def opened(browser: Any, address: str, request: pytest.FixtureRequest) -> Iterator[tuple[Any, list[str]]]:
    """The page at the width and color scheme of the test, and what it complains of."""
    width, scheme, motion = getattr(request, "param", (1440, "light", "no-preference"))
    context = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme, reduced_motion=motion, offline=True
    )
    page = context.new_page()
    complaints: list[str] = []
    page.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(address)
    yield page, complaints
    context.close()


def unfold(page: Any) -> None:
    page.evaluate("() => document.querySelectorAll('details').forEach((item) => { item.open = true; })")


SIGHTS = [(width, scheme, "no-preference") for width, scheme in ((360, "light"), (820, "dark"), (1440, "light"))]


@pytest.mark.parametrize("opened", SIGHTS, indirect=True, ids=lambda sight: f"{sight[0]}-{sight[1]}")
def test_nothing_overflows_or_fails_and_everything_is_readable(opened: tuple[Any, list[str]]) -> None:
    page, complaints = opened
    unfold(page)
    page.wait_for_function("() => [...document.images].every((image) => image.complete)")
    assert page.evaluate("() => document.documentElement.scrollWidth") == page.viewport_size["width"]
    assert page.evaluate(WIDE) == []
    assert page.evaluate(BROKEN) == []
    assert page.evaluate(CONTRAST) == []
    assert complaints == []


@pytest.mark.parametrize("opened", [(360, "light", "no-preference")], indirect=True)
def test_on_a_phone_no_result_column_lies_beyond_the_edge(opened: tuple[Any, list[str]]) -> None:
    page, _ = opened
    unfold(page)
    cells = "() => [...document.querySelectorAll('.stacking td')].filter((c) => c.textContent.trim())"
    assert page.evaluate(f"{cells}.length") > 50
    assert page.evaluate(f"{cells}.filter((c) => c.getBoundingClientRect().right > innerWidth).length") == 0
    cut = (
        "() => [...document.querySelectorAll('.stacking .group th, pre')].filter((c) => c.scrollWidth > c.clientWidth)"
    )
    assert page.evaluate(f"{cut}.length") == 0
    label = "(c) => getComputedStyle(c, '::before').content.length > 2"
    assert page.evaluate(f"{cells}.every({label})")  # each says what it is
    first = page.locator("#compare-first")
    assert first.get_attribute("data-mode") == "over" and first.bounding_box()["width"] > 300
    assert first.bounding_box()["y"] + 200 < 900  # on the first screen


def test_the_first_screen_holds_pictures_and_the_result(opened: tuple[Any, list[str]]) -> None:
    page, _ = opened
    shown = ("#compare-first .before img", "#compare-first .after img:not([hidden])", ".results .chart", ".verdict")
    for part in shown:
        box = page.locator(part).first.bounding_box()
        assert box["y"] + box["height"] < 900, part
    again = page.locator("article", has=page.locator("a[href='#compare-first']"))
    assert again.count() == 1 and again.locator(".compare").count() == 0  # nothing of it stands twice


def test_claims_stand_with_their_verdicts_where_policies_begin(opened: tuple[Any, list[str]]) -> None:
    page, _ = opened
    claims = page.locator("#policies #table3_claims tbody tr:not(.group)")
    said = [claims.get_by_text(verdict).count() for verdict in ("cannot be said", "to decide")]
    assert claims.count() == sum(said) == 6 and all(said), said
    table = page.locator("#table3_claims .scroll")
    assert table.evaluate("(e) => e.scrollWidth <= e.clientWidth")  # nothing of it is out of sight


def test_ranks_and_slider_by_keyboard(opened: tuple[Any, list[str]]) -> None:
    page, complaints = opened
    compare = page.locator("#compare-first")
    for rank, other, key in (("2", "1", "ArrowLeft"), ("1", "2", "ArrowRight"), ("2", "1", "")):  # first: no twins
        assert compare.locator(f"[data-rank='{rank}']").is_visible()
        assert not compare.locator(f"[data-rank='{other}']").is_visible()
        assert compare.locator(".rank").text_content() == rank
        assert compare.locator(".turn").text_content() == f"Turn the scene of rank {rank}"
        assert page.locator(f"#{compare.locator('.turn').get_attribute('data-scene')}").count() == 1
        compare.locator("input[type=radio]:checked").focus()
        if key:
            page.keyboard.press(key)
    compare.locator(".mode:not(.turn)").focus()
    page.keyboard.press("Enter")
    assert compare.get_attribute("data-mode") == "over"
    compare.locator("input[type=range]").focus()
    page.keyboard.press("End")
    assert compare.locator(".pair").evaluate("(e) => e.style.getPropertyValue('--seam')") == "100%"
    box = compare.locator(".pair").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + 50)
    page.mouse.down()
    page.mouse.up()
    assert compare.locator("input[type=range]").input_value() == "25"
    assert complaints == []


def test_colors_films_and_large_pictures_by_keyboard(opened: tuple[Any, list[str]]) -> None:
    page, complaints = opened
    paper = "() => getComputedStyle(document.body).backgroundColor"
    chart = "() => getComputedStyle(document.querySelector('img.chart')).filter"
    light = page.evaluate(paper)
    assert page.evaluate(chart) == "none"
    page.locator("#theme").focus()
    page.keyboard.press("Space")
    assert page.evaluate(paper) != light and page.evaluate(chart).startswith("invert")  # no white sheet in the dark
    shown = ".film img"
    moving = page.locator(shown).first.evaluate("(e) => e.currentSrc")
    page.locator("#motion").focus()
    page.keyboard.press("Enter")
    assert page.locator("#motion").get_attribute("aria-pressed") == "true"
    page.wait_for_function("([q, src]) => document.querySelector(q).currentSrc !== src", arg=[shown, moving])
    unfold(page)
    page.locator("button.picture").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("#viewer").is_visible() and page.locator("#viewer img").get_attribute("alt")
    page.keyboard.press("Escape")
    assert not page.locator("#viewer").is_visible()
    assert complaints == []


FRAME = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"  # drawn once more
DRAWN = """
() => {
  const canvas = document.querySelector('#turntable canvas');
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {willReadFrequently: true});
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  const colors = new Set();
  let sum = 0;
  for (let i = 0; i < data.length; i += 28) {
    const color = data[i] + 256 * data[i + 1] + 65536 * data[i + 2];
    colors.add(color);
    sum = (sum * 31 + color) % 1000003;
  }
  return {colors: colors.size, sum};
}
"""


@pytest.mark.parametrize(
    "opened", [(820, "light", "reduce"), (360, "dark", "reduce")], indirect=True, ids=["screen", "phone"]
)
def test_a_scene_turns_by_drag_and_keys_and_its_door_opens(opened: tuple[Any, list[str]]) -> None:
    page, complaints = opened
    page.locator("button.turn").first.click()
    table, canvas = page.locator("#turntable"), page.locator("#turntable canvas")
    page.wait_for_function("() => document.activeElement.matches('#turntable canvas')")
    first = page.evaluate(DRAWN)
    assert first["colors"] > 12  # floor, wall, cabinet, shadow and their edges
    whole, below = table.bounding_box(), table.locator(".below").bounding_box()
    assert whole["width"] <= page.viewport_size["width"] and below["height"] > 20
    assert below["y"] + below["height"] <= whole["y"] + whole["height"] + 1  # nothing is cut off

    def changed(what: str, before: dict[str, float]) -> dict[str, float]:
        page.evaluate(FRAME)
        now: dict[str, float] = page.evaluate(DRAWN)
        assert now["sum"] != before["sum"], what
        return now

    page.keyboard.press("ArrowRight")
    seen = changed("a key", first)
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2 + 60, box["y"] + box["height"] / 2 + 20, steps=3)
    page.mouse.up()
    seen = changed("a drag", seen)
    page.mouse.wheel(0, -200)
    seen = changed("the wheel", seen)
    table.locator("input[type=range]").focus()
    page.keyboard.press("End")
    seen = changed("the door", seen)
    table.locator(".turning").click()
    assert changed("turning", seen) and table.locator(".turning").get_attribute("aria-pressed") == "true"
    with page.expect_download() as saved:
        table.locator("a").click()
    assert Path(saved.value.path()).read_bytes()[:4] == b"glTF"
    table.locator(".close").click()
    assert not table.is_visible() and [line for line in complaints if "GPU stall" not in line] == []


@pytest.mark.parametrize("opened", [(820, "light", "reduce")], indirect=True)
def test_films_stand_still_where_the_system_asks_for_it(opened: tuple[Any, list[str]]) -> None:
    page, _ = opened
    first = page.locator(".film").first
    still = first.locator("source").get_attribute("srcset")
    assert first.locator("img").evaluate("(e) => e.currentSrc") == still
    assert page.locator("#motion").get_attribute("aria-pressed") == "true"


def test_a_page_without_its_script_says_so_and_the_scene_can_be_saved(
    browser: Any, address: str, tmp_path: Path
) -> None:
    alone = Path(shutil.copy(address.removeprefix("file://"), tmp_path))
    page = browser.new_page()
    page.goto(alone.as_uri())
    page.locator("button.turn").first.click()
    page.wait_for_selector("#turntable p:not([hidden])")
    assert "three.min.js" in page.locator("#turntable p").text_content()
    assert page.locator("#turntable a").get_attribute("href").startswith("blob:")
    page.close()
