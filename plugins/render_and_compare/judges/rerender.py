"""Judge `rerender`: an asset is turned, rescaled, placed, and photographed again as the object was (paper B.1).

The k_ori nearest stored views are rendered again so, and ordered by their distance to the object, all in one batch.
"""

from roomkin.plugins.render_and_compare.rendering import render
from roomkin.plugins.render_and_compare.workbench import Workbench
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.matching.encoders import encode_rows, make_encoder
from roomkin.stages.matching.ranking import compare, make_query
from roomkin.stages.matching.snapshots import DIGITS, AbstainedError, Question


class Judge:
    """Models are left in their order by distance, as in the paper."""

    def __init__(self, options: MatchingConfig) -> None:
        self.options = options
        self.encoder = make_encoder(options)
        self.workbench = Workbench("rerender", options.hog.image_size)

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """By distance."""
        return by_distance

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """The k_ori nearest, by the distance of their new pictures; the others are left out."""
        near = by_distance[: self.options.k_ori]
        fitter, solid = self.workbench.fitter(question), self.workbench.solid(question, asset)
        boxes = [fitter.box_of(solid, fitter.floor_yaw(one.yaw)) for one in near]
        views = [render(solid, box, fitter.seen).view(fitter.seen, question.view.up) for box in boxes]
        query = make_query(question.view, self.encoder, self.options.colour)
        rows = encode_rows(self.encoder, views)
        shown = [number for number, patches in enumerate(rows) if len(patches)]
        if query is None or not shown:
            raise AbstainedError("rerender: nothing of the asset is seen in the object's place")
        _, distances = compare(
            query, lambda number: rows[shown[number]], len(shown), self.options, symmetric=self.options.symmetric
        )
        again = sorted(zip(distances.round(DIGITS), shown, strict=True))
        return [near[number].model_copy(update={"distance": float(distance)}) for distance, number in again]
