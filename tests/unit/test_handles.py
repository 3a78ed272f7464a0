"""Handles of fronts that nobody described: knobs as wide as they are, no frames, none hidden by what is far ahead."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from roomkin.plugins.importing.tests.test_fronts import box, joint
from roomkin.stages.articulated.handle import exact_width, explain_ungraspable, find_handle, measure_handle
from roomkin.stages.articulated.model import RobotModel, link_frames
from roomkin.stages.articulated.urdf_reader import read_urdf

FRAME = [  # a raised frame of 60 x 80 cm, 6 cm wide, 2 cm before its panel
    box("0.02 0.06 0.8", "0.02 -0.27 0"), box("0.02 0.06 0.8", "0.02 0.27 0"),
    box("0.02 0.6 0.06", "0.02 0 -0.37"), box("0.02 0.6 0.06", "0.02 0 0.37"),
]  # fmt: skip


def front(folder: Path, *parts: str, ahead: str = "") -> RobotModel:
    """A door of 60 x 80 cm with parts on it, in the z-y plane at x = 0.01."""
    door = box("0.02 0.6 0.8", "0 0 0") + "".join(parts)
    body = box("0.4 0.6 0.8", "-0.22 0 0") + ahead
    text = (
        f'<robot name="c"><link name="body">{body}</link><link name="door">{door}</link>'
        f"{joint('hinge', 'revolute', 'door', '0 0 1', 1.6, '0 0 0')}</robot>"
    )
    (folder / "c.urdf").write_text(text)
    robot = read_urdf(folder / "c.urdf", folder)
    return replace(robot, joints=[replace(one, part_type="door", handle_link="door") for one in robot.joints])


def told(robot: RobotModel) -> tuple[str | None, str | None]:
    frames = link_frames(robot)
    return measure_handle(robot, robot.joints[0], frames), explain_ungraspable(robot, robot.joints[0], frames)


def test_identical_knobs_are_equally_wide_wherever_they_sit() -> None:
    widths = []
    for shift in np.linspace(0, 0.004, 9):
        panel = trimesh.creation.box((0.02, 0.5, 0.4))
        knob = trimesh.creation.cylinder(0.0345, 0.03, sections=64)
        knob.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
        knob.apply_translation([0.025, 0.1 + shift, 0.05 + shift / 3])
        mesh = trimesh.util.concatenate([panel, knob])
        handle = find_handle(mesh)
        assert handle is not None
        widths.append(exact_width(mesh, handle))
    assert np.ptp(widths) < 0.001
    assert np.mean(widths) == pytest.approx(0.069, abs=0.0005)


@pytest.mark.parametrize(("across", "kind"), [(0.0695, "knob"), (0.0705, None)])
def test_a_knob_as_wide_as_a_gripper_holds(tmp_path: Path, across: float, kind: str | None) -> None:
    handle, why = told(front(tmp_path, box(f"0.04 {across} {across}", "0.03 0.2013 0.0037")))
    assert handle == kind
    assert why == (None if kind else "what stands out of its front is 7.05 cm wide, and a gripper holds 7")


@pytest.mark.parametrize(
    ("part", "kind", "place"),
    [
        (box("0.02 0.015 0.2", "0.04 0.27 0.1"), "bar", 0.05),
        (box("0.014 0.03 0.03", "0.037 0.27 0.1"), "knob", 0.044),
        (box("0.018 0.015 0.2", "0.019 0.1 0"), "bar", 0.028),
    ],
    ids=["a bar on the frame", "a knob hardly before the frame", "a bar within the frame, lower than it"],
)
def test_a_raised_frame_is_no_handle(tmp_path: Path, part: str, kind: str, place: float) -> None:
    robot = front(tmp_path, *FRAME, part)
    assert told(robot) == (kind, None)
    mesh = trimesh.util.concatenate([visual.mesh for visual in robot.links["door"].visuals])
    handle = find_handle(mesh)
    assert handle is not None
    assert handle.position[0] == pytest.approx(place, abs=1e-6)


def test_a_frame_alone_is_nothing_to_hold(tmp_path: Path) -> None:
    handle, why = told(front(tmp_path, *FRAME))
    assert handle is None
    assert why is not None
    assert "cm wide, and a gripper holds 7" in why


@pytest.mark.parametrize(("distance", "why"), [(0.3, "25 cm before its handle stands something else"), (3.0, None)])
def test_only_what_stands_near_is_in_the_way(tmp_path: Path, distance: float, why: str | None) -> None:
    bar = box("0.02 0.015 0.2", "0.04 0.2 0")
    robot = front(tmp_path, bar, ahead=box("0.02 1 1", f"{distance + 0.01} 0 0"))
    assert told(robot) == (None if why else "bar", why)


@pytest.mark.parametrize(("count", "known"), [(9, False), (10, True)])
def test_a_front_that_few_rays_hit_has_no_handle(count: int, known: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    hits = np.zeros((count, 3))
    hits[-2:] = [[0.05, 0.0, -0.1], [0.05, 0.0, 0.1]]
    monkeypatch.setattr("roomkin.stages.articulated.handle.front_hits", lambda mesh: hits)
    assert (find_handle(trimesh.Trimesh()) is not None) == known
