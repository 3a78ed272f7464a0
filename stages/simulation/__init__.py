"""SAPIEN and ManiSkill: loading, rendering and resizing assets, the robot, the registered tasks."""

import importlib
import os
import sys
from types import ModuleType
from typing import Any

# Of Mesa's software renderer, read when it starts: a second thread costs more than it brings, and every core has a job.
os.environ.setdefault("LP_NUM_THREADS", "1")

# ManiSkill imports it, and with it MuJoCo, for a controller that few use.
KINEMATICS = "pytorch_kinematics"


def _import_late(attribute: str) -> Any:
    if attribute.startswith("__"):
        raise AttributeError(attribute)
    del sys.modules[KINEMATICS]
    return getattr(importlib.import_module(KINEMATICS), attribute)


if "mani_skill" not in sys.modules:
    sys.modules[KINEMATICS] = ModuleType(KINEMATICS)
    sys.modules[KINEMATICS].__getattr__ = _import_late  # type: ignore[method-assign]
