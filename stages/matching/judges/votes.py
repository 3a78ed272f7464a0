"""Judge `votes`: votes of the patches (A.6, official code)."""

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.matching.snapshots import Question


class Judge:
    """In the order in which they won their rounds."""

    def __init__(self, options: MatchingConfig) -> None:
        pass

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """The winners, then the others by distance."""
        voted = {candidate.asset for candidate in by_votes}
        return by_votes + [candidate for candidate in by_distance if candidate.asset not in voted]

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """The winners."""
        return by_votes
