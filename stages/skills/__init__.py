"""The skills that demonstrate the tasks (paper A.4): one folder each, over shared primitives.

`motion.py` moves the hand, `path.py` makes paths, `rollout.py` tries candidates out, `clearance.py` knows what they
must not touch; `articulate.py` and `handle_grasp.py` are what Open and Close share.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from stages.config.demonstrations import DemonstrationsConfig
    from stages.tasks.api import TaskEnv

Float = NDArray[np.float32]
Act = Callable[[Float, bool], None]  # executes and records one action (7,); whether noise may disturb it


@dataclass(frozen=True)
class Outcome:
    """How a skill ended: 'success', or the step that failed; how often it tried again after a miss."""

    success: bool
    cause: str
    retries: int = 0


class SkillProtocol(Protocol):
    """One skill of a task's chain: made once per task, run once per attempt, on the task as it then stands.

    What to act on the skill asks of the task: its target joint (Open, Close), its movable objects (Pick, Place). It
    begins where the skill before it has ended: at a handle just let go of, or with an object in the gripper.
    """

    def __init__(self, task: "TaskEnv", options: "DemonstrationsConfig") -> None: ...

    def run(self, act: Act) -> Outcome:
        """Do it, through the actions that a policy has."""
        ...
