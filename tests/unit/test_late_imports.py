"""What ManiSkill imports for a controller that few use is not loaded, and is there when asked for."""

import subprocess
import sys

CODE = """
import sys
import stages.tasks.environment
assert not {"mujoco", "pandas"} & sys.modules.keys()
from mani_skill.agents.controllers.utils import kinematics
assert kinematics.pk.PseudoInverseIK.__module__ == "pytorch_kinematics.ik"
"""


def test_an_environment_loads_no_mujoco_and_the_other_controller_still_finds_its_kinematics() -> None:
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
