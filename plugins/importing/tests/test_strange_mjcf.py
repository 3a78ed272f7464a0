"""MJCF as packs of other people have it: what MuJoCo takes is imported, all else is refused in its own words."""

from pathlib import Path

import pytest

from plugins.importing.importers.mjcf import read_mjcf
from plugins.importing.tests.test_strange_packs import mjcf
from tests.refusals import refused

BOX = '<geom type="box" size=".1 .1 .1"/>'


@pytest.mark.parametrize(
    ("inside", "before", "said"),
    [
        ("<region/>", "", "unrecognized element"),
        ('<joint name="j" axis="0 0 0"/>', "", "axis"),
        ("", '<asset><material name="m"/><material name="m"/></asset>', "repeated name 'm'"),
    ],
)
def test_what_mujoco_refuses_is_told_in_its_words(tmp_path: Path, inside: str, before: str, said: str) -> None:
    path = mjcf(tmp_path / "a.xml", f"{before}<worldbody><body>{inside}{BOX}</body></worldbody>")
    with refused("E-MJCF-REFUSED") as told:
        read_mjcf(path, tmp_path)
    assert said in str(told.value) and "\n" not in str(told.value)


def test_a_range_counts_where_it_need_not_hold_if_it_ends_closed(tmp_path: Path) -> None:
    for told, moves in (("0 2.7", True), ("-1.5 0", True), ("-10.3 10.3", False)):
        turns = f'<body><joint name="j" axis="0 0 1" limited="false" range="{told}"/>{BOX}</body>'
        text = f'<compiler angle="radian"/><worldbody>{turns}</worldbody>'
        robot = read_mjcf(mjcf(tmp_path / "a.xml", text), tmp_path)
        assert (robot.joints[0].type == "revolute") == moves
