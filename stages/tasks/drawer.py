"""Drawer Opening (paper B.4).

**Randomizations:**
- the robot stands 65 cm before the handle, off by up to 3 cm, 7 cm in height, 18 degrees
- the cabinet is off by up to 2 cm and 6 degrees, and stretched along each axis by a factor of 0.75 to 1.25
- the arm's joints by 0.02 radians, the camera by 1 cm and 3 degrees

**Success Conditions:**
- the drawer is open by half of its range or 15 cm, whichever is less

**Goal:**
- Pull a drawer out of a cabinet by its handle
"""

from roomkin.stages.tasks.task import Task, register

TASK = register(Task(gym_id="ACDC-OpenDrawer-v1", skills=("roomkin.stages.skills.open",), part_type="drawer"))
