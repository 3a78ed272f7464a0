"""The environment of Door Opening."""

from stages.tasks.environment import OpenTaskEnv


class OpenDoorEnv(OpenTaskEnv):
    """The target joint is revolute: `opened` is the share of its range, success is `task.success_fraction` of it."""
