"""The Open skill: Approach, Converge, Grasp, Articulate, Ungrasp (paper A.4)."""

from roomkin.stages.planning.articulation import choose_open_goals, choose_release_opening
from roomkin.stages.simulation.target import Target
from roomkin.stages.skills.articulate import ArticulateSkill


class OpenSkill(ArticulateSkill):
    """Opens the target joint of a task as it stands, somewhat further than success needs."""

    @property
    def spare(self) -> float:
        """Radians; some where another skill follows: from a joint limit it finds no plan."""
        return 0.2 if len(self.task.task.skills) > 1 else 0.0

    def goals(self, target: Target) -> tuple[float, ...]:
        return choose_open_goals(target, self.task.success_opening, self.options.goal_margin)

    def has_moved_enough(self, goal: float) -> bool:
        target, options = self.task.env.target, self.options
        return self.task.opened >= choose_release_opening(target, self.task.success_opening, options.goal_margin, goal)

    def is_done(self) -> bool:
        return self.task.opened >= self.task.success_opening


Skill = OpenSkill
