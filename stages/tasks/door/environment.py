"""The environment of Door Opening."""

from stages.tasks.door import TASK
from stages.tasks.environment import OpenTaskEnv


class OpenDoorEnv(OpenTaskEnv):
    """The target joint is revolute: success is half of its range or 60 degrees, whichever is less."""

    task = TASK
