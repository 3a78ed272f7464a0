"""The environment of Drawer Opening."""

from stages.tasks.environment import OpenTaskEnv


class OpenDrawerEnv(OpenTaskEnv):
    """The target joint is prismatic: `opened` is the share of its range, success is `task.success_fraction` of it."""
