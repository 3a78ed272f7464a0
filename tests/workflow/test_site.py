"""The documentation as a site, opened from the disk without a network: nothing comes of another host, search finds."""

import subprocess
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from roomkin.plugins.report.tests.test_report_browser import browser as browser
from tests.workflow.workspace import ROOT

LOADS = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src", "video": "src"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site of these docs, as `make site` builds it."""
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        ["bash", "envs/docs.sh", "--site-dir", str(folder)], cwd=ROOT, capture_output=True, text=True
    )
    assert built.returncode == 0, built.stderr[-3000:]
    return folder


class Loads(HTMLParser):
    """Addresses that a page loads as it opens."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found += [value for name, value in attributes if name == LOADS.get(tag) and value]


def test_no_page_loads_anything_of_another_host(site: Path) -> None:
    pages = {page: Loads(page.read_text(encoding="utf-8")).found for page in site.rglob("*.html")}
    assert len(pages) > 40 and all(pages.values())
    assert not [(page.name, each) for page, found in pages.items() for each in found if "//" in each]


@pytest.fixture
def opened(browser: Any, site: Path) -> Iterator[tuple[Any, list[str]]]:
    """The first page, from the disk without a network, and what it asked other hosts for."""
    context = browser.new_context(offline=True)
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if request.url.startswith("http") else None)
    page.goto((site / "index.html").as_uri())
    yield page, asked
    context.close()


def test_the_search_finds_a_page_without_a_network(opened: tuple[Any, list[str]]) -> None:
    page, asked = opened
    page.locator(".md-search__input").click()
    page.keyboard.type("lavapipe")
    page.locator(".md-search-result__link[href*='install.html?h=lavapipe']").click()
    page.wait_for_url("**/install.html*")
    assert asked == []
