"""ManiSkill, in which demonstrations are made, too."""

from stages.tasks.api import EnvWrapper as Environment

__all__ = ["Environment"]
