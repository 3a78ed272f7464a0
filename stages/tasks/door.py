"""Door Opening (paper B.4).

**Randomizations:**
- the robot stands where its arm can follow the handle, 65 cm before it, off by up to 3 cm, 7 cm in height, 18 degrees
- the cabinet is off by up to 2 cm and 6 degrees, and stretched along each axis by a factor of 0.75 to 1.25
- the arm's joints by 0.02 radians, the camera by 1 cm and 3 degrees

**Success Conditions:**
- the door is open by half of its range or 60 degrees, whichever is less

**Goal:**
- Open the door of a cabinet that hangs on an upright hinge, by its handle
"""

from roomkin.stages.tasks.task import Task, register

TASK = register(Task(gym_id="ACDC-OpenDoor-v1", skills=("roomkin.stages.skills.open",), part_type="door"))
