"""The environment of Drawer Opening."""

from stages.tasks.drawer import TASK
from stages.tasks.environment import OpenTaskEnv


class OpenDrawerEnv(OpenTaskEnv):
    """The target joint is prismatic: success is half of its range or 15 cm, whichever is less."""

    task = TASK
