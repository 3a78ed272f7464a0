"""A joint is shut where the model is smallest, whatever its zero."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stages.articulated.forward_kinematics import measure_closed_box, shut_where_smallest
from stages.articulated.model import JointModel, RobotModel
from stages.articulated.urdf_reader import read_urdf
from tests.unit.articulated_models import write_cabinet


@pytest.fixture
def cabinet(tmp_path: Path) -> RobotModel:
    return read_urdf(write_cabinet(tmp_path), tmp_path)


def draw_open(joint: JointModel) -> JointModel:
    """The joint as a file has it that is drawn with it open at 0, and shut at its upper limit."""
    span = joint.upper - joint.lower
    return replace(joint, origin=joint.origin @ joint.motion(joint.upper), axis=-joint.axis, lower=0.0, upper=span)


def test_a_model_that_is_shut_stays_as_it_is(cabinet: RobotModel) -> None:
    assert shut_where_smallest(cabinet) is cabinet


def test_a_door_that_is_drawn_open_is_shut(cabinet: RobotModel) -> None:
    opened = replace(cabinet, joints=[draw_open(one) if one.name == "hinge" else one for one in cabinet.joints])
    assert np.ptp(measure_closed_box(opened), axis=0)[0] > 0.9
    shut = shut_where_smallest(opened)
    assert measure_closed_box(shut) == pytest.approx(measure_closed_box(cabinet))
    assert "'hinge' is taken to be shut at 1.5" in shut.remarks[-1]
    (hinge,) = (joint for joint in shut.joints if joint.name == "hinge")
    assert hinge.lower == 0 and hinge.upper == pytest.approx(1.5)
