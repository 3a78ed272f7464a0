"""ManiSkill, in which demonstrations are made, too."""

from stages.tasks.api import TaskEnv as Environment

__all__ = ["Environment"]
