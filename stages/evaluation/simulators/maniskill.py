"""ManiSkill, in which demonstrations are made, too."""

from roomkin.stages.tasks.api import EnvWrapper as Environment

__all__ = ["Environment"]
