"""MJCF as packs of other people have it: parts of simulations, made for older versions, without their textures."""

from pathlib import Path

import numpy as np
import pytest

from stages.assets.importers.mjcf import read_mjcf
from tests.unit.test_strange_packs import mjcf

pytest.importorskip("mujoco")


def test_a_texture_that_is_missing_is_grey(tmp_path: Path) -> None:
    looks = '<texture type="cube" file="../textures/oak.png"/><material name="m" texture="oak"/>'
    thing = '<worldbody><geom type="box" size=".1 .1 .1" material="m"/></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"<asset>{looks}</asset>{thing}"), tmp_path)
    (visual,) = robot.links["world"].visuals
    assert visual.colour is not None
    assert len(set(visual.colour[:3])) == 1 and visual.colour[0] < 1
    assert robot.remarks[0].startswith("grey in place of a texture: there is no file '../textures/oak.png'")


def test_defaults_of_older_mujoco(tmp_path: Path) -> None:
    red = '<default class="red"><geom rgba="1 0 0 1"/></default>'
    defaults = f'<default class="base"><geom rgba="0 1 0 1"/>{red}</default>'
    geoms = "".join(f'<geom type="box" size=".1 .1 .1" {told}/>' for told in ("", 'class="base"', 'class="red"'))
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"{defaults}<worldbody>{geoms}</worldbody>"), tmp_path)
    assert [visual.colour[:3] for visual in robot.links["world"].visuals if visual.colour] == [
        (0, 1, 0),
        (0, 1, 0),
        (1, 0, 0),
    ]


TABLE = '<worldbody><body name="table" pos="0 0 -1"><geom type="box" size="1 1 1"/></body></worldbody>'


def test_what_is_included_around_a_thing_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(f"<mujocoinclude>{TABLE}</mujocoinclude>")
    thing = '<worldbody><body name="cup"><geom type="box" size=".05 .05 .05"/></body></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "cup.xml", f'<include file="scene.xml"/>{thing}'), tmp_path)
    assert "cup" in robot.links and "table" not in robot.links
    assert robot.remarks == ("left out, as included around it: 'table'",)
    floor = '<worldbody><geom type="plane" size="1 1 1"/></worldbody>'
    robot = read_mjcf(mjcf(tmp_path / "whole.xml", f'<include file="scene.xml"/>{floor}'), tmp_path)
    assert "table" in robot.links and not robot.remarks, "the included file is the model"


@pytest.mark.parametrize(
    ("compiler", "upper", "expected"),
    [("", "1.5", 1.5), ("", "90", np.pi / 2), ('<compiler angle="degree"/>', "1.5", np.deg2rad(1.5))],
)
def test_hinges_of_a_few_units_turn_by_radians(tmp_path: Path, compiler: str, upper: str, expected: float) -> None:
    hinge = f'<joint name="j" axis="0 0 1" limited="true" range="0 {upper}"/>'
    turns = f'<body>{hinge}<geom type="box" size=".1 .1 .1"/></body>'
    robot = read_mjcf(mjcf(tmp_path / "a.xml", f"{compiler}<worldbody>{turns}</worldbody>"), tmp_path)
    assert robot.joints[0].upper == pytest.approx(expected)
