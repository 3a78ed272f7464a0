"""Putting Away Bowl (paper B.4): open a drawer, put the bowl in, shut it."""

from stages.tasks.task import Task, register

TASK = register(
    Task(
        gym_id="ACDC-PutAwayBowl-v1",
        environment="plugins.bowl.tasks.put_away_bowl.environment:PutAwayBowlEnv",
        skills=("stages.skills.open", "plugins.bowl.skills.pick", "plugins.bowl.skills.place", "stages.skills.close"),
        role="drawer",
        horizon=220,
    )
)
