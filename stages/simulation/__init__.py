"""SAPIEN and ManiSkill: loading, rendering and resizing assets, the robot, the registered tasks."""
