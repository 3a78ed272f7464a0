"""Judge `geometry`: analysis by synthesis, with no model at all (paper A.6 and B.1 ask a language model instead).

The `geometry.nearest` models by distance are fitted into the object's place, turned each way that it can stand, and
ordered by how well what is then seen agrees with the picture, and by what is known besides (label, counts, size,
place), in the same unit. How alike their patches look chose them and counts no more: that sees textures. The others
follow by distance.
"""

from collections.abc import Sequence
from typing import Any

from roomkin.plugins.render_and_compare.fits import Fit
from roomkin.plugins.render_and_compare.package import GeometryConfig
from roomkin.plugins.render_and_compare.workbench import Workbench
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.matching.candidates import sum_priors
from roomkin.stages.matching.snapshots import DIGITS, Question

MIN_FIT = 0.7  # of a perfect score: below it, how models differ in their scores says nothing; chosen


class Judge:
    """Weights and size of the pictures: `geometry` of the options."""

    def __init__(self, options: Any) -> None:
        """`options`: a `MatchingConfig` with the section `geometry`."""
        self.options: MatchingConfig = options
        self.weights: GeometryConfig = options.geometry
        self.workbench = Workbench("geometry", self.weights.resolution)

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """The nearest by their best fit and by what is known, ties by distance; then the others.

        Where the first of them does not fit (the box is wrong, the mask lacks parts, the library has nothing like it),
        the fit would choose at random: then only what is known counts.
        """
        near, rest = by_distance[: self.weights.nearest], by_distance[self.weights.nearest :]
        fits = [self._list_fits(question, candidate.asset)[0] for candidate in near]
        scores = [fit.score(self.weights) for fit in fits]
        knowns = [sum_priors(candidate) for candidate in near]
        first = max(range(len(near)), key=lambda number: scores[number] - knowns[number])
        trust = scores[first] >= MIN_FIT * self.weights.perfect
        judged = [
            candidate.model_copy(
                update={
                    "score": round(trust * score - known, DIGITS),
                    "terms": _round_terms(fit) | {"priors": round(known, DIGITS)},
                }
            )
            for candidate, fit, score, known in zip(near, fits, scores, knowns, strict=True)
        ]
        return sorted(judged, key=lambda one: one.score or 0.0, reverse=True) + rest

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """By fit: as its front is known; else along the object's box, and as in the k_ori nearest views."""
        views = [] if self.workbench.fitter(question).front_known else by_distance[: self.options.k_ori]
        fits = self._list_fits(question, asset, [view.yaw for view in views])
        return [
            Orientation(yaw=fit.yaw, score=round(fit.score(self.weights), DIGITS), terms=_round_terms(fit))
            for fit in fits
        ]

    def _list_fits(self, question: Question, asset: str, views: Sequence[float] = ()) -> list[Fit]:
        """Best first."""
        fitter = self.workbench.fitter(question)
        yaws = fitter.aligned + [fitter.floor_yaw(view) for view in views]
        fits = fitter.fit(self.workbench.solid(question, asset), yaws)
        return sorted(fits, key=lambda fit: round(fit.score(self.weights), DIGITS), reverse=True)


def _round_terms(fit: Fit) -> dict[str, float]:
    return {name: round(float(value), DIGITS) for name, value in fit.terms._asdict().items()}
