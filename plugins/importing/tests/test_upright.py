"""Which way is up in files that say otherwise than their format: what hinges, slides, the foot and the size tell."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.importing.evidence import collect_evidence
from roomkin.plugins.importing.fronts import doors_and_drawers
from roomkin.plugins.importing.importers import Axis
from roomkin.plugins.importing.imports import axis_vector
from roomkin.plugins.importing.tests.test_fronts import box, joint
from roomkin.stages.articulated.model import RobotModel, change_root, measure_closed_box
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.geometry.frames import make_transform

BACK, LEVEL, UPRIGHT = "0 -1 0", "0 1 0", "0 0 -1"


def link(name: str, *shapes: str) -> str:
    return f'<link name="{name}">{"".join(shapes)}</link>'


def turning(body: str, name: str, panel: str, axis: str, xyz: str) -> str:
    return link("body", body) + link(name, panel) + joint(f"{name}_hinge", "revolute", name, axis, 1.5, xyz)


STAR = box("0.5 0.06 0.06", "0 0 0.03") + box("0.06 0.5 0.06", "0 0 0.03") + box("0.05 0.05 0.3", "0 0 0.2")
SEAT = link("seat", box("0.48 0.48 0.08", "0 0 0.45") + box("0.05 0.45 0.46", "-0.22 0 0.72"))
COLUMN = link("column", box("0.04 0.04 0.3", "0 0 0.22"))
LIFT = joint("lift", "prismatic", "seat", "0 0 1", 0.1, "0 0 0")
FRIDGE = turning(box("0.6 0.7 1.8", "-0.3 0 0.9"), "door", box("0.05 0.7 1.76", "0.025 0.35 0"), UPRIGHT, "0 -0.35 0.9")
OVEN = turning(box("0.55 0.6 0.85", "0 0 0.425"), "door", box("0.05 0.55 0.5", "0.025 0 0.25"), LEVEL, "0.275 0 0.12")
SAFE = turning(box("0.4 0.4 0.5", "0 0 0.25"), "door", box("0.04 0.38 0.46", "0.02 0.19 0"), UPRIGHT, "0.2 -0.19 0.25")
DRAWERS = (
    link("body", box("0.4 0.5 0.8", "0 0 0.4"))
    + link("drawer", box("0.02 0.5 0.2"))
    + joint("slide", "prismatic", "drawer", "1 0 0", 0.25, "0.21 0 0.4")
)
CHAIR = link("body", STAR) + SEAT + LIFT
SWIVEL = (
    link("body", STAR) + COLUMN + SEAT + joint("lift", "prismatic", "column", "0 0 1", 0.1, "0 0 0")
    + joint("swivel", "revolute", "seat", "0 0 1", 3.1, "0 0 0", "column")
)  # fmt: skip
STANDS = {  # with the direction that is their format's: nothing may lay them down
    "chair": CHAIR,
    "swivelling chair": SWIVEL,
    "stool": link("body", box("0.4 0.4 0.02", "0 0 0.01") + box("0.06 0.06 0.6", "0 0 0.3"))
    + link("seat", box("0.38 0.38 0.06", "0 0 0.63"))
    + joint("lift", "prismatic", "seat", "0 0 1", 0.2, "0 0 0"),
    "desk": link("body", box("0.6 0.08 0.04", "0 -0.5 0.02") + box("0.08 1.1 0.6", "0 0 0.3"))
    + link("top", box("0.7 1.4 0.03", "0 0 0.735"), box("0.06 1 0.5", "0 0 0.47"))
    + joint("lift", "prismatic", "top", "0 0 1", 0.4, "0 0 0"),
    "laptop": turning(box("0.24 0.34 0.02", "0 0 0.01"), "screen", box("0.24 0.34 0.01", "0.12 0 0.005"), BACK,
                      "-0.12 0 0.02"),
    "trash_can": turning(box("0.28 0.3 0.5", "0 0 0.25"), "lid", box("0.29 0.31 0.06", "0.145 0 0.03"), BACK,
                         "-0.145 0 0.5"),
    "toilet": turning(box("0.5 0.36 0.4", "0 0 0.2"), "seat", box("0.45 0.36 0.02", "0.225 0 0.01"), BACK,
                      "-0.23 0 0.4"),
    "faucet": turning(box("0.05 0.05 0.2", "0 0 0.1"), "lever", box("0.12 0.02 0.02", "0.06 0 0.01"), BACK,
                      "0 0 0.2"),
    "freezer": turning(box("0.65 1.2 0.8", "0 0 0.4"), "lid", box("0.66 1.2 0.07", "0.33 0 0.035"), BACK,
                       "-0.33 0 0.8"),
    "washing_machine": turning(box("0.55 0.6 0.85", "0 0 0.425"), "door", box("0.05 0.4 0.4", "0.025 0.2 0"), UPRIGHT,
                               "0.275 -0.2 0.45"),
    "window": link("body", box("0.1 0.05 1.2", "0 -0.4 0.6"), box("0.1 0.05 1.2", "0 0.4 0.6"))
    + link("sash", box("0.03 0.76 0.55", "0 0 0.3")) + joint("slide", "prismatic", "sash", "0 0 1", 0.5, "0 0 0"),
    "oven": OVEN, "fridge": FRIDGE, "safe": SAFE, "chest_of_drawers": DRAWERS,
}  # fmt: skip


def model(folder: Path, text: str) -> RobotModel:
    (folder / "a.urdf").write_text(f'<robot name="r">{text}</robot>')
    return read_urdf(folder / "a.urdf", folder)


def turned(robot: RobotModel, up: Axis, front: Axis, grounded: bool) -> RobotModel:
    """The model in a file whose `up` is up, standing at its origin's height or about its origin."""
    x, z = axis_vector(front), axis_vector(up)
    rotation = np.array([x, np.cross(z, x), z]).T
    low, high = measure_closed_box(robot)
    foot = np.array([*(low + high)[:2] / 2, low[2] if grounded else (low + high)[2] / 2])
    return change_root(robot, make_transform(rotation, -rotation @ foot))


@pytest.mark.parametrize("name", STANDS)
def test_no_joint_lays_down_what_stands(tmp_path: Path, name: str) -> None:
    robot = model(tmp_path, STANDS[name])
    for front in ("+x", "-x", "+y", "-y"):
        for grounded in (True, False):
            for category in (name.rpartition(" ")[2], "thing"):
                told = collect_evidence(turned(robot, "+z", front, grounded)).find_up(category, "+z", True)
                assert (told.axis, told.doubt) == ("+z", ""), (front, grounded, category)


@pytest.mark.parametrize(
    ("text", "category", "up", "front", "grounded", "because"),
    [
        (FRIDGE, "fridge", "+y", "+z", False, "hinges and size"),
        (FRIDGE, "fridge", "+x", "+z", False, "hinges and size"),
        (FRIDGE, "fridge", "+y", "-x", True, "hinges and foot and size"),
        (SAFE, "safe", "+y", "+z", False, "hinges"),
        (OVEN, "oven", "+y", "+z", False, "hinges"),
        (DRAWERS, "thing", "+y", "+z", False, "slides"),
        (DRAWERS, "thing", "+x", "+z", True, "slides and foot"),
        (CHAIR, "chair", "+y", "+z", True, "slides and foot and size"),
    ],
)
def test_hinges_and_slides_tell_up(
    tmp_path: Path, text: str, category: str, up: Axis, front: Axis, grounded: bool, because: str
) -> None:
    told = collect_evidence(turned(model(tmp_path, text), up, front, grounded)).find_up(category, "+z", True)
    assert (told.axis, told.because) == (up, because)


def test_what_is_not_enough_against_the_format_is_a_doubt(tmp_path: Path) -> None:
    told = collect_evidence(turned(model(tmp_path, STANDS["toilet"]), "+y", "+z", True)).find_up("toilet", "+z", True)
    assert told.axis == "+z" and told.doubt == "its foot would have +y"


def test_a_seat_on_its_gas_lift_is_no_drawer_however_it_lies(tmp_path: Path) -> None:
    robot = turned(model(tmp_path, CHAIR), "+x", "+y", True)
    assert doors_and_drawers(robot)[1] == [
        "fixed, as no door or drawer: 'lift' (slides on something narrower than itself)"
    ]
    top = box("0.55 0.6 0.03", "0.075 0 0.815")  # of a desk, far before its drawer
    for text in (DRAWERS, DRAWERS.replace("</link>", f"{top}</link>", 1)):
        drawer, lines = doors_and_drawers(model(tmp_path, text))
        assert lines == [] and drawer.joints[0].type == "prismatic"


def test_what_turns_about_its_own_middle_tells_nothing_of_what_is_up(tmp_path: Path) -> None:
    """A wheel at a cabinet's side, and a swivelling plate; a door tells."""
    plate = box("0.5 0.5 0.03", "0 0.03 0")  # not quite in the middle
    for panel, axis, at, count in (
        (box("0.4 0.03 0.4"), "0 1 0", "0 0.27 0.4", 0),
        (plate, "1 0 0", "0 0 0.83", 0),
        (box("0.02 0.5 0.4", "0 0.25 0"), UPRIGHT, "0.26 -0.25 0.4", 1),
    ):
        told = collect_evidence(model(tmp_path, turning(box("0.5 0.5 0.8", "0 0 0.4"), "part", panel, axis, at)))
        assert len(told.hinges) == count


def test_a_drawer_that_is_cut_stays_where_it_is_closed(tmp_path: Path) -> None:
    robot = model(tmp_path, DRAWERS.replace('lower="0" upper="0.25"', 'lower="0.1" upper="2"'))
    ((slide,), lines) = doors_and_drawers(robot)[0].joints, doors_and_drawers(robot)[1]
    assert slide.lower == 0.1 and slide.upper - slide.lower == pytest.approx(
        np.ptp(measure_closed_box(robot), axis=0)[0]
    )
    assert len(lines) == 1 and "slides 190 cm in its file, cut to" in lines[0]


def test_buttons_say_nothing_of_what_is_up(tmp_path: Path) -> None:
    """A drawer that slides along y, so z is up; three wide pads that lift a little, and a knob."""
    parts = {"drawer": box("0.5 0.4 0.2"), **{f"button_{n}": box("0.18 0.3 0.02") for n in range(3)}}
    text = f'<link name="body">{box("0.6 0.5 0.8")}</link><link name="knob">{box("0.03 0.03 0.03")}</link>'
    text += "".join(f'<link name="{name}">{part}</link>' for name, part in parts.items())
    text += joint("slide", "prismatic", "drawer", "0 1 0", 0.3, "0 0.1 0")
    text += "".join(
        joint(f"press_{n}", "prismatic", f"button_{n}", "0 0 1", 0.004, f"{0.2 * n - 0.2} 0 0.4") for n in range(3)
    )
    text += joint("turn", "revolute", "knob", "0 1 0", 0.05, "0 0.25 0.3")
    (tmp_path / "a.urdf").write_text(f'<robot name="r">{text}</robot>')
    told = collect_evidence(read_urdf(tmp_path / "a.urdf", tmp_path))
    assert len(told.slides) == 1 and not told.hinges and told.find_up("chest_of_drawers").axis == "+z"
