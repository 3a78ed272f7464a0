"""Who decides on model and orientation (paper A.6, B.1); the judges lie beside this file."""

from pathlib import Path
from typing import NamedTuple, Protocol

from stages.config.matching import MatchingConfig
from stages.contracts.cousins import Candidate, Orientation
from stages.matching.crop import View
from stages.plugins import load


class Question(NamedTuple):
    """What a judge may look at: the object as the camera sees it, its label, and library.json with the models."""

    view: View
    label: str
    library: Path


class Judge(Protocol):
    """Made from the options of `matching`. It gets both rankings, best first, and answers with its own."""

    def __init__(self, options: MatchingConfig) -> None: ...

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """Candidates, best first. `by_votes` has the `k_model` that won a round, `by_distance` all."""
        ...

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """Views of one asset, best first. `by_votes` has the `k_ori` that won a round, `by_distance` all."""
        ...


class Judges:
    """The two judges that the options name, and the library that they may look at."""

    def __init__(self, options: MatchingConfig, library: Path) -> None:
        self.library = library
        self.of_models: Judge = load("judges", options.model_selection)(options)
        self.of_orientations: Judge = load("judges", options.orientation_selection)(options)
