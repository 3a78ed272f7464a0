"""The Place skill: Move, Ungrasp, Lift (paper A.4)."""

from roomkin.plugins.bowl.skills.place.skill import PlaceSkill as Skill

__all__ = ["Skill"]
