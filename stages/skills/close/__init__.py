"""The Close skill: as Open, with start and end of the joint's path reversed (paper A.4)."""

from stages.simulation.target import Target
from stages.skills.articulate import ArticulateSkill

SHUT = 0.03  # of the range: a door at 3 degrees, a drawer at a centimetre


class CloseSkill(ArticulateSkill):
    """Closes the target joint of a task from wherever it stands."""

    def goals(self, target: Target) -> tuple[float, ...]:
        return (target.lower,)

    def enough(self) -> bool:
        return self.task.opened <= SHUT

    def done(self) -> bool:
        return self.task.opened <= SHUT


Skill = CloseSkill
