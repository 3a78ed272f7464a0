"""SAPIEN and ManiSkill: loading, rendering and resizing assets, the robot, the registered tasks."""

import importlib
import os
import sys
from types import ModuleType
from typing import Any

# Of Mesa's software renderer, read when it starts: a second thread costs more than it brings, and every core has a job.
os.environ.setdefault("LP_NUM_THREADS", "1")

# What ManiSkill imports, and with it Matplotlib, MuJoCo and IPython, for a controller that few use and for notebooks.
KINEMATICS, NOTEBOOKS = "pytorch_kinematics", "mani_skill.utils.visualization.jupyter_utils"


def _import_late(attribute: str) -> Any:
    if attribute.startswith("__"):
        raise AttributeError(attribute)
    del sys.modules[KINEMATICS]
    return getattr(importlib.import_module(KINEMATICS), attribute)


if "mani_skill" not in sys.modules:
    for name, attribute, value in ((KINEMATICS, "__getattr__", _import_late), (NOTEBOOKS, "display_images", None)):
        sys.modules[name] = ModuleType(name)
        setattr(sys.modules[name], attribute, value)
