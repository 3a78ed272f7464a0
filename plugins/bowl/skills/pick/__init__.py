"""The Pick skill: Move, Grasp, Lift (paper A.4)."""

from roomkin.plugins.bowl.skills.pick.skill import PickSkill as Skill

__all__ = ["Skill"]
