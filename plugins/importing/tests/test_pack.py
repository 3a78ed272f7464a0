"""pack.yaml: what a folder's models share is told by most of them, proposed, and corrected by hand."""

import json
import shutil
from pathlib import Path

import pytest
import trimesh
import yaml

from roomkin.plugins.importing.evidence import Shared, read_pack
from roomkin.plugins.importing.import_ import run
from roomkin.plugins.importing.imports import Notes
from roomkin.plugins.importing.tests.test_fronts import box, cabinet, joint, write_partnet
from roomkin.plugins.report.tests.test_report_browser import FLAGS
from roomkin.stages.contracts.errors import InputError

Y_UP = '<origin rpy="-1.5707963 -1.5707963 0"/></joint><link'
FLAP = (
    f'<robot name="o"><link name="body">{box("0.6 0.6 0.8", "0 0 0.4")}</link>'
    f'<link name="flap">{box("0.02 0.5 0.5", "0 0 0.25")}{box("0.04 0.4 0.02", "0.03 0 0.45")}</link>'
    f"{joint('hinge', 'revolute', 'flap', '0 1 0', 1.5, '0.31 0 0.1')}</robot>"
)


def y_up(text: str) -> str:
    """A URDF of a model in a file whose y is up and whose front is +z."""
    root = '<link name="y_up"/><joint name="up" type="fixed"><parent link="y_up"/><child link="body"/>'
    head, name, rest = text.partition(">")
    return f"{head}{name}{root}{Y_UP}{rest.removeprefix('<link')}"


def chest(height: float) -> str:
    """A chest with a drawer."""
    return (
        f'<robot name="d"><link name="body">{box(f"0.4 0.5 {height}", f"0 0 {height / 2}")}</link>'
        f'<link name="drawer">{box("0.02 0.5 0.2")}{box("0.03 0.2 0.02", "0.03 0 0")}</link>'
        f"{joint('slide', 'prismatic', 'drawer', '1 0 0', 0.25, '0.21 0 0.4')}</robot>"
    )


def stools(count: int) -> dict[str, str]:
    """Seats on one leg, y up, without joints."""
    seats = [box("0.4 0.4 0.05", "0 0 0.45") + box(f"0.3 0.{3 - k} 0.45", "0 0 0.225") for k in range(count)]
    return {
        f"stool/s{k}": y_up(f'<robot name="s"><link name="body">{seat}</link></robot>') for k, seat in enumerate(seats)
    }


def written(folder: Path, models: dict[str, str]) -> Path:
    for name, text in models.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.urdf").write_text(text)
    return folder


def notes(mine: Path, name: str) -> tuple[str, str, str, bool]:
    told = Notes.model_validate_json((mine / name / "asset.json").read_text())
    return told.category, told.front or "", told.up or "", told.by_hand


def test_a_folder_of_urdfs_with_y_up_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    models = {f"chest_of_drawers/c{k}": y_up(chest(0.8 + 0.1 * k)) for k in range(3)} | stools(1)
    run(written(tmp_path / "theirs", models), out=tmp_path / "mine")
    for k in range(3):
        assert notes(tmp_path / "mine", f"chest_of_drawers/c{k}") == ("chest_of_drawers", "+z", "+y", False)
    assert notes(tmp_path / "mine", "stool/s0") == ("stool", "+z", "+y", False)
    assert "40 cm wide, 40 deep, 47.5 high" in capsys.readouterr().out
    pack = read_pack(tmp_path / "mine/pack.yaml")
    assert pack.kinds[".urdf"].up == "+y"
    assert pack.kinds[".urdf"].front == "+z"
    assert not pack.by_hand
    assert "# 4 models; up: 4 +y; " in (tmp_path / "mine/pack.yaml").read_text()


def test_one_urdf_with_y_up_is_told_by_its_drawers_and_a_flap_tells_nothing(tmp_path: Path) -> None:
    models = {"chest_of_drawers/c": y_up(chest(0.9)), "oven/o": FLAP, "bottom_cabinet/b": cabinet()}
    run(written(tmp_path / "theirs", models), out=tmp_path / "mine")
    assert [notes(tmp_path / "mine", name)[1:3] for name in models] == [("+z", "+y"), ("+x", "+z"), ("+x", "+z")]


@pytest.mark.parametrize("kind", ["glb", "urdf"])
def test_an_upright_box_is_not_laid_down(tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "theirs/box").mkdir(parents=True)
    if kind == "glb":
        trimesh.creation.box((0.1, 0.21, 0.1)).export(tmp_path / "theirs/box/carton.glb")
    else:
        text = f'<robot name="b"><link name="b">{box("0.1 0.1 0.21")}</link></robot>'
        (tmp_path / "theirs/box/carton.urdf").write_text(text)
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert "10 cm wide, 10 deep, 21 high" in capsys.readouterr().out


def test_what_is_changed_by_hand_counts_and_the_rest_is_guessed_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs = written(tmp_path / "theirs", stools(2))
    run(theirs, out=tmp_path / "mine")
    assert notes(tmp_path / "mine", "stool/s0")[2] == "+z", "two are too few to tell"
    pack = tmp_path / "mine/pack.yaml"
    told = yaml.safe_load(pack.read_text())
    told["kinds"][".urdf"] |= {"up": "+y", "unit": 1.0}
    told["categories"]["stool"] = "footstool"
    pack.write_text(json.dumps(told))  # as the page saves it
    corrected = tmp_path / "mine/stool/s1/asset.json"
    corrected.write_text(json.dumps(json.loads(corrected.read_text()) | {"front": "-x"}))
    run(theirs, out=tmp_path / "mine")
    assert notes(tmp_path / "mine", "stool/s0") == ("footstool", "+z", "+y", False)
    assert notes(tmp_path / "mine", "stool/s1") == ("stool", "-x", "+z", True)
    assert read_pack(pack).kinds[".urdf"].up == "+y"
    assert '<tr data-kind=".urdf">' in (tmp_path / "mine/index.html").read_text()


def test_more_models_may_tell_more_while_nothing_was_changed_by_hand(tmp_path: Path) -> None:
    run(written(tmp_path / "theirs", stools(2)), out=tmp_path / "mine")
    run(written(tmp_path / "theirs", {f"chest_of_drawers/c{k}": y_up(chest(0.8 + k / 9)) for k in range(3)}),
        out=tmp_path / "mine")  # fmt: skip
    assert read_pack(tmp_path / "mine/pack.yaml").kinds[".urdf"].up == "+y"
    assert notes(tmp_path / "mine", "stool/s0")[2] == "+y"


def test_the_page_saves_the_pack_that_is_chosen_on_it(tmp_path: Path) -> None:
    browser = shutil.which("chromium")
    if browser is None:
        pytest.skip("no chromium")
    run(written(tmp_path / "theirs", stools(2)), out=tmp_path / "mine")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as started:
        page = started.chromium.launch(executable_path=browser, args=FLAGS).new_page(
            viewport={"width": 390, "height": 844}
        )
        page.goto((tmp_path / "mine/index.html").as_uri())
        assert page.evaluate("() => document.documentElement.scrollWidth") == 390  # as a phone shows it
        page.select_option('[data-kind=".urdf"] [name=up]', "+y")
        page.select_option('[data-kind=".urdf"] [name=unit]', label="centimetres")
        page.fill('[data-name="stool"] input', "footstool")
        with page.expect_download() as saved:
            page.click("button")
        saved.value.save_as(tmp_path / "pack.yaml")
    pack = read_pack(tmp_path / "pack.yaml")
    assert pack.by_hand
    assert pack.kinds[".urdf"] == Shared(up="+y", unit=0.01)
    assert pack.categories == {"stool": "footstool"}


@pytest.mark.parametrize(("text", "why"), [("kinds: [", "is no YAML"), ("kinds: {.obj: {up: x}}", r"kinds\.\.obj\.up")])
def test_a_broken_pack_is_told(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "pack.yaml").write_text(text)
    with pytest.raises(InputError, match=why):
        read_pack(tmp_path / "pack.yaml")


@pytest.mark.parametrize("given", ["45132", "45132/mobility.urdf"])
def test_one_partnet_model_keeps_its_category_and_size(
    tmp_path: Path, given: str, capsys: pytest.CaptureFixture[str]
) -> None:
    flat = f'<robot name="m"><link name="l">{box("0.9 1.45 0.95")}</link></robot>'
    write_partnet(tmp_path / "theirs", "45132", flat, "Microwave")
    run(tmp_path / "theirs" / given, out=tmp_path / "mine")
    assert "as large as ours are" in capsys.readouterr().out
    assert notes(tmp_path / "mine", "microwave/45132")[0] == "microwave"
