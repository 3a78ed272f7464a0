"""MuJoCo, for door and drawer."""

from plugins.mujoco.environment import MujocoTaskEnv as Environment

__all__ = ["Environment"]
