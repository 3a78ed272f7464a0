"""A task, as far as it needs no simulator."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from roomkin.stages.articulated.affordance import Affordance, target_joint
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.parts import PartType


@dataclass(frozen=True)
class Task:
    """A task. Its environment (cameras, success) and its skills are named here and imported when used.

    gym_id: name for `gym.make`. skills: modules of the chain of skills that demonstrate it, in order. part_type: of the
    joint that it opens. horizon: steps after which an episode is over, unless `task.max_steps` says otherwise.
    environment: "module:Class", a subclass of the usual one.
    """

    gym_id: str
    skills: tuple[str, ...]
    part_type: PartType
    horizon: int = 100
    environment: str = "roomkin.stages.tasks.environment:OpenTaskEnv"

    def target_joint(self, folder: Path, like: Affordance | None = None, flaps: bool = False) -> Affordance | None:
        """The joint of the asset in `folder` that the task is about, None if none will do.

        Args:
            like: that of the twin.
            flaps: whether of an asset with no other door a flap will do.
        """
        return target_joint(folder, self.part_type, like, flaps)

    def suitable_joint(self, folder: Path) -> str:
        """The name of that joint.

        Raises:
            InputError: the asset has none.
        """
        panel = self.target_joint(folder)
        if panel is None:
            what = f"has no {self.part_type} with a handle."
            raise InputError(folder, what, "choose another asset", code="E-TASK-JOINT")
        return panel.joint


def register(task: Task) -> Task:
    """Make a task known to `gym.make`, where there is gymnasium; the environment is imported when it is made."""
    with suppress(ImportError):
        import gymnasium

        if task.gym_id not in gymnasium.registry:
            kwargs = {"task": task}
            gymnasium.register(task.gym_id, entry_point=task.environment, disable_env_checker=True, kwargs=kwargs)
    return task
