"""A joint is shut where the model is smallest and its part lies along it, whatever its zero and its limits."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from roomkin.plugins.importing.fronts import doors_and_drawers, front_direction
from roomkin.plugins.importing.hinges import shut_where_smallest
from roomkin.plugins.importing.importers.mjcf import read_mjcf
from roomkin.plugins.importing.tests.test_coupled_doors import PAIR
from roomkin.plugins.importing.tests.test_fronts import box
from roomkin.stages.articulated.model import RobotModel, link_frames, measure_closed_box
from roomkin.stages.articulated.urdf_reader import read_urdf
from tests.unit.articulated_models import write_cabinet

SIZE = (0.57, 0.6, 0.8)  # closed: a body 50 cm deep that faces +x, fronts of 2 cm and handles of 5 before it


class Part(NamedTuple):
    """A part of the body: its joint, the axis on which it comes out, where it is, and its boxes (size, center)."""

    kind: str
    axis: tuple[int, int, int]
    place: tuple[float, float, float]
    boxes: tuple[tuple[str, str], ...]


def panel(middle: str, handle: str) -> tuple[tuple[str, str], ...]:
    """Boxes of a front of 56 x 30 cm and its handle; their centers in the plane of the body's front."""
    return ("0.02 0.56 0.3", f"0.01{middle[1:]}"), ("0.05 0.05 0.05", f"0.045{handle[1:]}")


PARTS = {
    "left": Part("revolute", (0, 0, -1), (0.25, -0.28, 0.3), panel("0 0.28 0", "0 0.5 0")),
    "right": Part("revolute", (0, 0, 1), (0.25, 0.28, 0.3), panel("0 -0.28 0", "0 -0.5 0")),
    "top": Part("revolute", (0, -1, 0), (0.25, 0, 0.45), panel("0 0 -0.2", "0 0 -0.35")),
    "slide": Part("prismatic", (1, 0, 0), (0.25, 0, 0.65), (*panel("0 0 0", "0 0 0"), ("0.45 0.5 0.15", "-0.225 0 0"))),
}
BODY = ("0.5 0.6 0.8", "0 0 0.4")
Limits = tuple[float, float]
Drawn = tuple[float, Limits, int]  # by how much a part is drawn open, its limits from there, and 1 or -1: of its axis


def place(name: str, given: Drawn) -> tuple[Part, str, str, str, str]:
    """A part; place and angles of its frame; axis and limits of its joint."""
    part, (at, limits, way) = PARTS[name], given
    moved = at * np.array(part.axis)
    slid, turned = (moved, 0 * moved) if part.kind == "prismatic" else (0 * moved, moved)
    words = (slid + part.place, turned, way * np.array(part.axis), sorted(way * end for end in limits))
    return part, *(" ".join(f"{value:.6g}" for value in each) for each in words)


def write_urdf(folder: Path, joints: dict[str, Drawn]) -> RobotModel:
    links, lines = [f'<link name="body">{box(*BODY)}</link>'], []
    for name, given in joints.items():
        part, xyz, rpy, axis, limits = place(name, given)
        low, high = limits.split()
        links.append(f'<link name="{name}_link">{"".join(box(*one) for one in part.boxes)}</link>')
        lines.append(
            f'<joint name="{name}" type="{part.kind}"><parent link="body"/><child link="{name}_link"/>'
            f'<axis xyz="{axis}"/><origin xyz="{xyz}" rpy="{rpy}"/><limit lower="{low}" upper="{high}"/></joint>'
        )
    (folder / "a.urdf").write_text(f'<robot name="a">{"".join(links + lines)}</robot>')
    return read_urdf(folder / "a.urdf", folder)


def write_mjcf(folder: Path, joints: dict[str, Drawn]) -> RobotModel:
    def geom(size: str, center: str) -> str:
        half = " ".join(f"{float(extent) / 2}" for extent in size.split())
        return f'<geom type="box" size="{half}" pos="{center}"/>'

    bodies = geom(*BODY)
    for name, given in joints.items():
        part, pos, euler, axis, limits = place(name, given)
        kind = "hinge" if part.kind == "revolute" else "slide"
        joint = f'<joint name="{name}" type="{kind}" axis="{axis}" limited="true" range="{limits}"/>'
        bodies += f'<body pos="{pos}" euler="{euler}">{joint}{"".join(geom(*one) for one in part.boxes)}</body>'
    text = f'<compiler angle="radian"/><worldbody><body>{bodies}</body></worldbody>'
    (folder / "a.xml").write_text(f"<mujoco>{text}</mujoco>")
    return read_mjcf(folder / "a.xml", folder)


HINGES, SLIDES = ("left", "right", "top"), ("slide",)
CASES = [  # parts; by how much they are drawn open; limits from there; the range that is right
    (HINGES, 0, (0, 1.57), 1.57),
    (HINGES, 0, (-3.14159, 3.14159), 3.14159),
    (HINGES, 0, (-1.57, 1.57), 1.57),
    (HINGES, 0, (-0.1, 1.57), 1.57),
    (HINGES, 0, (-0.03, 1.2), 1.2),
    (HINGES, 0, (-0.5, 1.3), 1.3),
    (HINGES, 0, (-1.57, 0.6), 0.6),
    (HINGES, 0, (-6.28, 6.28), 6.28),
    (HINGES, 0.5, (-0.5, 1.0), 1.5),
    (HINGES, 0.2, (-0.2, 1.2), 1.4),
    (HINGES[:2], 0.12, (-0.12, 1.2), 1.32),
    (HINGES, 1.5, (-1.5, 0), 1.5),
    (HINGES, 1.5, (-1.5, 0.3), 1.8),
    (SLIDES, 0, (0, 0.35), 0.35),
    (SLIDES, 0, (-0.3, 0.3), 0.3),
    (SLIDES, 0, (-0.05, 0.35), 0.35),
    (SLIDES, 0, (-0.1, 0.35), 0.35),
    (SLIDES, 0, (-0.2, 0.35), 0.35),
    (SLIDES, 0, (-1, 1), 1),
    (SLIDES, 0, (-0.4, 0.2), 0.2),
    (SLIDES, 0.15, (-0.15, 0.2), 0.35),
    (SLIDES, 0.35, (-0.35, 0), 0.35),
]
EACH = [(part, at, limits, right) for parts, at, limits, right in CASES for part in parts]


Write = Callable[[Path, dict[str, Drawn]], RobotModel]


@pytest.mark.parametrize("write", [write_urdf, write_mjcf])
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize(("part", "at", "limits", "right"), EACH)
def test_size_front_and_range(
    tmp_path: Path, write: Write, way: int, part: str, at: float, limits: Limits, right: float
) -> None:
    robot = shut_where_smallest(write(tmp_path, {part: (at, limits, way)}))
    assert np.ptp(measure_closed_box(robot), axis=0) == pytest.approx(SIZE, abs=1e-3)
    (joint,) = (one for one in robot.joints if one.name == part)
    assert joint.upper - joint.lower == pytest.approx(right, abs=1e-4)
    facing = front_direction(robot)
    assert facing is not None and facing[0] == pytest.approx([1, 0, 0])
    again = shut_where_smallest(robot)
    assert np.ptp(measure_closed_box(again), axis=0) == pytest.approx(SIZE, abs=1e-3)


def ranges(robot: RobotModel) -> dict[str, float]:
    """Of each joint, to two digits."""
    return {joint.name: round(joint.upper - joint.lower, 2) for joint in robot.joints}


def test_several_joints_at_once(tmp_path: Path) -> None:
    wide = {"left": (0, (-3.14, 3.14), 1), "slide": (0.2, (-0.2, 0.1), -1)}
    robot = shut_where_smallest(write_urdf(tmp_path, wide))
    assert np.ptp(measure_closed_box(robot), axis=0) == pytest.approx(SIZE, abs=1e-3)
    assert ranges(robot) == {"left": 3.14, "slide": 0.3}
    assert robot.remarks == (
        "'slide' is taken to be shut at 0.2, where the model is smallest, not at 0",
        "taken to be shut at 0, between their limits, as drawn: 'left' (-3.14 to 3.14) opens to 3.14",
    )
    both = shut_where_smallest(write_urdf(tmp_path, {"left": (0, (-2, 2), 1), "slide": (0, (-0.3, 0.3), 1)}))
    assert "'left' (-2 to 2) opens to 2, 'slide' (-0.3 to 0.3) opens to 0.3" in both.remarks[0]


@pytest.mark.parametrize("limits", ['lower="0" upper="1.6"', 'lower="-1.6" upper="1.6"', 'lower="-3.14" upper="3.14"'])
def test_what_follows_is_shut_as_what_it_follows(tmp_path: Path, limits: str) -> None:
    (tmp_path / "a.urdf").write_text(PAIR.replace('lower="0" upper="1.6"', limits))
    robot = shut_where_smallest(read_urdf(tmp_path / "a.urdf", tmp_path))
    assert np.ptp(measure_closed_box(robot), axis=0) == pytest.approx((0.42, 0.8, 0.8), abs=1e-3)
    lead, follower = robot.joints
    assert (follower.follows, follower.lower, follower.upper) == ("leads", lead.lower, lead.upper)
    middle = link_frames(robot, 0.8 / lead.upper)
    assert middle["left"][0, :] @ [0, 0.4, 0, 1] > 0.3


def test_a_pair_that_is_drawn_open_is_shut_together(tmp_path: Path) -> None:
    text = PAIR.replace('lower="0" upper="1.6"', 'lower="-1.5" upper="0.1"')
    text = text.replace('xyz="0.2 0.4 0.4"', 'xyz="0.2 0.4 0.4" rpy="0 0 1.5"')
    text = text.replace('xyz="0.2 -0.4 0.4"', 'xyz="0.2 -0.4 0.4" rpy="0 0 -1.5"')
    (tmp_path / "a.urdf").write_text(text)
    robot = shut_where_smallest(read_urdf(tmp_path / "a.urdf", tmp_path))
    assert np.ptp(measure_closed_box(robot), axis=0) == pytest.approx((0.42, 0.8, 0.8), abs=1e-3)


def test_a_door_that_turns_too_far_is_doubted(tmp_path: Path) -> None:
    for limits, doubted in (((-6.28, 6.28), True), ((0, 4), True), ((-3.14, 3.14), False)):
        robot, lines = doors_and_drawers(shut_where_smallest(write_urdf(tmp_path, {"left": (0, limits, 1)})))
        assert robot.joints[0].type == "revolute"
        assert any("no door does" in line for line in lines) == doubted


def test_a_model_that_is_shut_stays_as_it_is(tmp_path: Path) -> None:
    robot = read_urdf(write_cabinet(tmp_path), tmp_path)
    assert shut_where_smallest(robot) is robot


def test_a_joint_that_is_drawn_open_is_told(tmp_path: Path) -> None:
    robot = shut_where_smallest(write_urdf(tmp_path, {"left": (1.5, (-1.5, 0), 1)}))
    assert robot.remarks == ("'left' is taken to be shut at 1.5, where the model is smallest, not at 0",)
