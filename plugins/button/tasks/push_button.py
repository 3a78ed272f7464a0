"""Push Button.

**Randomizations:**
- the robot stands 65 cm before the button and 50 cm below it, off by up to 3 cm, 7 cm in height, 18 degrees
- the box is off by up to 2 cm and 6 degrees, and stretched along each axis by a factor of 0.75 to 1.25
- the arm's joints by 0.02 radians, the camera by 1 cm and 3 degrees

**Success Conditions:**
- the button is pushed in by half of its range. It is sprung: let go of, it comes out again

**Goal:**
- Push the button on the front of a box with the closed gripper
"""

from roomkin.stages.tasks.task import Task, register

TASK = register(
    Task(gym_id="ACDC-PushButton-v1", skills=("roomkin.plugins.button.skills.push",), part_type="button", horizon=60)
)
