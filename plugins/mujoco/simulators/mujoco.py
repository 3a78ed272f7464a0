"""MuJoCo, for door and drawer."""

from roomkin.plugins.mujoco.environment import MujocoTaskEnv as Environment

__all__ = ["Environment"]
