"""Putting Away Bowl (paper B.4).

**Randomizations:**
- robot, cabinet, arm and cameras as in Drawer Opening
- the stand before the cabinet is off by up to 4 cm and 5 cm in height, the bowl on it by 1.5 cm, turned at will

**Success Conditions:**
- the bowl stands in the drawer, its foot on the drawer's floor
- the drawer is shut: open by 10 % of its range at most
- the gripper does not hold the bowl

**Goal:**
- Open the drawer, take the bowl off its stand, put it in, and shut the drawer
"""

from roomkin.stages.tasks.task import Task, register

TASK = register(
    Task(
        gym_id="ACDC-PutAwayBowl-v1",
        skills=(
            "roomkin.stages.skills.open",
            "roomkin.plugins.bowl.skills.pick",
            "roomkin.plugins.bowl.skills.place",
            "roomkin.stages.skills.close",
        ),
        part_type="drawer",
        horizon=220,
        environment="roomkin.plugins.bowl.tasks.put_away_bowl.environment:PutAwayBowlEnv",
    )
)
