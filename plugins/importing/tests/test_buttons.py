"""What is sprung or called a button is one that a task can push, or stays fixed with the reason; it is no drawer."""

from dataclasses import replace
from pathlib import Path

import pytest

from roomkin.plugins.importing.hinges import explain_unpushable, mark_buttons
from roomkin.plugins.importing.import_ import run
from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.importing.tests.own_models import import_folder
from roomkin.plugins.importing.tests.test_fronts import box, cabinet, joint
from roomkin.stages.articulated.model import link_frames
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.plugins import load

CASE = f'<link name="case">{box("0.2 0.3 0.3", "0 0 0.15")}</link>'


def write(folder: Path, link: str = "link_1", name: str = "press", axis: str = "-1 0 0", reach: float = 0.01,
          side: float = 0.05, dynamics: str = "", at: str = "0.11 0 0.15") -> Path:  # fmt: skip
    """A case with a slide on its front."""
    press = joint(name, "prismatic", link, axis, reach, at, "case").replace("</joint>", f"{dynamics}</joint>")
    folder.mkdir(parents=True)
    cap = f'<link name="{link}">{box(f"0.04 {side} {side}")}</link>'
    (folder / "mobility.urdf").write_text(f'<robot name="b">{CASE}{cap}{press}</robot>')
    return folder


def test_a_name_a_spring_or_semantics_make_a_button(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "mine" / "control_box"
    write(mine / "1", link="start_button")
    write(mine / "2", name="emergencySwitch")
    write(mine / "3", dynamics='<dynamics stiffness="80"/>')
    (write(mine / "4") / "semantics.txt").write_text("case static case\nlink_1 slider button\n")
    (write(mine / "5") / "semantics.txt").write_text("case static case\nlink_1 slider lever\n")
    write(mine / "6", link="button_1", at='0.11 0 0.15" rpy="0 0 1.5708', axis="0 1 0")  # along x, in a turned frame
    assets = {asset.id[-1]: asset for asset in import_folder(tmp_path / "mine", tmp_path / "models")}
    said = capsys.readouterr().out
    for number in "12346":
        (found,) = assets[number].joints
        assert (found.part_type, found.handle, assets[number].drawers) == ("button", "face", 0)
        folder = tmp_path / "models" / assets[number].id
        assert load("tasks", "push_button").target_joint(folder).joint == found.name
        assert load("tasks", "drawer").target_joint(folder) is None
    assert assets["5"].joints == [] and "'press' (slides by less than 5 cm)" in said
    assert said.count("sprung, and pushed, not pulled") == 5


def test_only_a_slide_is_a_button_and_moves_by_both_its_limits(tmp_path: Path) -> None:
    (tmp_path / "c.urdf").write_text(cabinet())
    robot = mark_buttons(read_urdf(tmp_path / "c.urdf", tmp_path), {"hinge", "press"})
    assert {one.name for one in robot.joints if one.part_type == "button"} == {"press"}
    folder = write(tmp_path / "case", link="button_1")
    robot = read_urdf(folder / "mobility.urdf", folder)
    (press,), frames = robot.joints, link_frames(robot)
    assert explain_unpushable(robot, press, frames) == ""
    assert explain_unpushable(robot, replace(press, lower=-0.1), frames).endswith("moves by 11 cm")


@pytest.mark.parametrize(
    ("about", "why"),
    [
        ({"reach": 0.2, "axis": "1 0 0"}, "moves by 20 cm"),
        ({"axis": "1 0 0"}, "comes out when it moves"),
        ({"side": 0.012}, "smaller than 2 cm"),
    ],
)
def test_what_cannot_be_pushed_stays_fixed(
    about: dict[str, object], why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "mine" / "control_box" / "1", link="button_1", **about)  # type: ignore[arg-type]
    (asset,) = import_folder(tmp_path / "mine", tmp_path / "models")
    assert asset.joints == [] and why in capsys.readouterr().out


def test_it_stays_one_when_it_was_proposed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`import` writes a URDF of its own, without semantics.txt."""
    (write(tmp_path / "mine" / "control_box" / "4") / "semantics.txt").write_text("link_1 slider button\n")
    run(tmp_path / "mine", out=tmp_path / "out")
    assert "button 'press': 1 cm, handle: face" in capsys.readouterr().out
    (asset,) = import_folder(tmp_path / "out", tmp_path / "models")
    assert [one.part_type for one in asset.joints] == ["button"]


def test_mjcf_says_that_a_slide_is_sprung(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text(
        '<mujoco><worldbody><body><geom type="box" size=".1 .1 .1"/>'
        '<body pos=".11 0 0"><joint name="a" type="slide" axis="-1 0 0" range="0 .01" stiffness="90"/>'
        '<geom type="box" size=".02 .02 .02"/></body>'
        '<body pos=".11 .05 0"><joint name="b" type="slide" axis="-1 0 0" range="0 .01"/>'
        '<geom type="box" size=".02 .02 .02"/></body></body></worldbody></mujoco>'
    )
    found = {one.name: one.part_type for one in read_mjcf(tmp_path / "a.xml", tmp_path).joints}
    assert (found["a"], found["b"]) == ("button", None)
