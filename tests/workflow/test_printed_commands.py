"""Every command that a page of a run prints is one: flags that it takes, targets that are planned."""

import re
import shlex
from html import unescape
from pathlib import Path

import pytest

from roomkin.plugins.report import overview, picture, report
from roomkin.stages.contracts import Camera, write_json
from tests.unit.tables_results import CAMERA, VIEWER, declared, write_run
from tests.workflow.test_documents import check_roomkin, check_snakemake, folder  # noqa: F401
from tests.workflow.workspace import ROOT

PRINTED = re.compile(r"<(?:code|pre)[^>]*>(.*?)</(?:code|pre)>", re.DOTALL)


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """The commands on the page of a run, on that of a run of nothing, of a picture and over all pictures."""
    root = write_run(tmp_path_factory.mktemp("run"))
    flags = declared(root)
    of_room = tuple(path for path in flags["files"] if {"room_1", "snapshots"} & set(path.parts))  # type: ignore[attr-defined]
    report.run(out=root / "run.html", viewer=VIEWER, **flags)  # type: ignore[arg-type]
    report.run(out=root / "nothing.html")
    write_json(root / "camera.json", Camera(width=240, height=160, intrinsics=CAMERA))
    image = root / "results/scenes/room_1/input/rgb.png"
    picture.run(
        files=of_room, image=image, camera=root / "camera.json", scene="room_1", out=root / "room_1.html", viewer=VIEWER
    )
    overview.run(scenes=("room_1",), variant="default", out=root / "overview.html")
    pages = [path.read_text() for path in root.glob("*.html")]
    texts = [unescape(text) for page in pages for text in PRINTED.findall(page)]
    lines = [
        re.sub(r"\s+# .*", "", line).strip() for text in texts for line in re.sub(r"\n--", " --", text).splitlines()
    ]
    return {" ".join(line.split()) for line in lines if re.match(r"(roomkin|snakemake|make) ", line)}


def test_a_command_on_a_page_is_one(printed: set[str], folder: Path) -> None:  # noqa: F811
    words = [shlex.split(line) for line in sorted(printed)]
    assert {line[0] for line in words} == {"make", "roomkin", "snakemake"} and len(words) > 6
    for program, *rest in words:
        if program == "roomkin":
            check_roomkin(rest)
        elif program == "snakemake":
            check_snakemake(folder, rest)
        else:
            assert re.search(rf"^{rest[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), rest
