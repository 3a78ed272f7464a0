"""The Open skill: Approach, Converge, Grasp, Articulate, Ungrasp (paper A.4)."""

from stages.skills.open.skill import OpenSkill as Skill

__all__ = ["Skill"]
