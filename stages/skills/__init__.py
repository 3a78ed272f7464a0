"""The skills that demonstrate the tasks (paper A.4): one folder each, over shared primitives.

`motion.py` moves the hand and tries again after a miss; `articulate.py` is what Open and Close share.
Motions are planned in `stages/planning`.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from roomkin.stages.config.training import DemonstrationsConfig
    from roomkin.stages.tasks.api import EnvWrapper

Float = NDArray[np.float32]
FAR = float("inf")


class Act(Protocol):
    """Executes one action and records it."""

    def __call__(self, action: Float, noisy: bool, ahead: float = FAR) -> None:
        """Do `action` (7,).

        Args:
            noisy: whether noise may be added to what is executed.
            ahead: metres that the hand still has to go to a grasp, if that is where it goes: what may be disturbed.
        """
        ...


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

    def __init__(self, task: "EnvWrapper", options: "DemonstrationsConfig") -> None: ...

    def run(self, act: Act) -> Outcome:
        """Do it, through the actions that a policy has."""
        ...
