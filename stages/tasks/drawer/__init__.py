"""Drawer Opening (paper B.4)."""

from stages.tasks.task import Task, register

TASK = register(
    Task(
        gym_id="ACDC-OpenDrawer-v1",
        environment="stages.tasks.drawer.environment:OpenDrawerEnv",
        skills=("stages.skills.open",),
        role="drawer",
    )
)
