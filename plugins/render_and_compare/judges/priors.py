"""Judge `priors`: nothing but label, counts, box and mounting; no picture is looked at. The baseline of the others.

Named for models and for orientations, nothing is encoded and nothing compared (`MatchingConfig.compares_pictures`).
"""

import numpy as np

from roomkin.plugins.render_and_compare.observation import aligned_yaws, is_front_known
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.geometry.frames import view_angle
from roomkin.stages.matching.candidates import sum_priors
from roomkin.stages.matching.snapshots import DIGITS, AbstainedError, Question


class Judge:
    """Weights: `label_weight`, `size_weight`, `place_weight`, `count_weight` of the options."""

    def __init__(self, options: MatchingConfig) -> None:
        pass

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """All candidates by what label, size, place and counts add, ties by id."""
        return sorted(by_distance, key=lambda one: (round(sum_priors(one), DIGITS), one.asset))

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """As its front is known; else along its box, front towards the camera."""
        item, scene = question.item, question.scene
        if item is None or scene is None or item.box is None:
            raise AbstainedError("priors: extraction gives no box")
        eye = np.array(scene.floor_from_camera)[:3, 3]
        yaws = [view_angle(eye, item.box.center, yaw) for yaw in aligned_yaws(item, scene)]
        ordered = yaws if is_front_known(item, scene) else sorted(yaws, key=abs)
        return [Orientation(yaw=yaw) for yaw in ordered]
