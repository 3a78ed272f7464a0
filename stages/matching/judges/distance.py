"""Judge `distance`: embedding distance (A.6, B.1)."""

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.matching.snapshots import Question


class Judge:
    """Nearest first."""

    def __init__(self, options: MatchingConfig) -> None:
        pass

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """By distance."""
        return by_distance

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """By distance."""
        return by_distance
