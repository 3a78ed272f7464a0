"""The Close skill: as Open, with start and end of the joint's path reversed (paper A.4)."""

from roomkin.stages.simulation.target import Target
from roomkin.stages.skills.articulate import ArticulateSkill
from roomkin.stages.tasks.base_placement import CLOSED


class CloseSkill(ArticulateSkill):
    """Closes the target joint of a task from wherever it stands."""

    def goals(self, target: Target) -> tuple[float, ...]:
        return (target.lower,)

    def has_moved_enough(self, goal: float) -> bool:
        return self.task.opened <= CLOSED / 2

    def is_done(self) -> bool:
        return self.task.opened <= CLOSED


Skill = CloseSkill
