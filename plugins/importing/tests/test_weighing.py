"""Masses that nothing of such a size has become those of boards, inertias with them."""

from pathlib import Path

import numpy as np
import pytest

from plugins.importing.inertia_repair import repair_inertias
from plugins.importing.tests.test_fronts import box, joint
from stages.articulated.model import Link
from stages.articulated.urdf_reader import read_urdf


def _drawer(folder: Path, kilograms: float) -> tuple[Link, list[str]]:
    """A drawer that weighs so much in its file, weighed sanely, and what is said of it."""
    parts = box("0.02 0.5 0.2") + box("0.3 0.45 0.15", "-0.16 0 0")
    inertial = f'<inertial><mass value="{kilograms}"/><inertia ixx="{kilograms / 30}" iyy="{kilograms / 60}" '
    inertial += f'izz="{kilograms / 40}" ixy="0" ixz="0" iyz="0"/></inertial>'
    text = f'<robot name="r"><link name="body">{box("0.4 0.5 0.6", "-0.21 0 0.3")}</link><link name="d">{inertial}'
    text += f"{parts}</link>{joint('slide', 'prismatic', 'd', '1 0 0', 0.3, '0.01 0 0.3')}</robot>"
    (folder / "a.urdf").write_text(text)
    robot, lines = repair_inertias(read_urdf(folder / "a.urdf", folder))
    return robot.links["d"], lines


def test_what_is_taken_for_boards_turns_as_if_it_were_of_boards(tmp_path: Path) -> None:
    (kept, nothing), (lighter, lines) = _drawer(tmp_path, 4.0), _drawer(tmp_path, 4000.0)
    assert nothing == []
    assert lines[-1:] == [f"what 'slide' moves weighs 4e+03 kg in its file: taken for boards, {lighter.mass:.2g} kg"]
    assert kept.mass == 4.0 and 2 < lighter.mass < 6
    np.testing.assert_allclose(np.diag(kept.inertia), [4 / 30, 4 / 60, 4 / 40])
    assert lighter.inertia / lighter.mass == pytest.approx(kept.inertia / kept.mass)
