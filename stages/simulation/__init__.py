"""SAPIEN and ManiSkill: loading, rendering and resizing assets, the robot, the registered tasks."""

import os

# Of Mesa's software renderer, read when it starts: a second thread costs more than it brings, and every core has a job.
os.environ.setdefault("LP_NUM_THREADS", "1")
