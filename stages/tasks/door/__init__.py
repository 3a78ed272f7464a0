"""Door Opening (paper B.4)."""

from stages.tasks.task import Task, register

TASK = register(
    Task(
        gym_id="ACDC-OpenDoor-v1",
        environment="stages.tasks.door.environment:OpenDoorEnv",
        skills=("stages.skills.open",),
        role="door",
    )
)
