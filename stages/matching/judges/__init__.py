"""Who decides on model and orientation (paper A.6, B.1); the judges lie beside this file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from stages.config.matching import MatchingConfig
from stages.contracts import Objects
from stages.contracts.cousins import Candidate, Orientation
from stages.contracts.objects import SceneObject
from stages.matching.crop import View
from stages.matching.snapshots import Snapshots
from stages.plugins import load


class Question(NamedTuple):
    """What a judge may look at: the object as the camera sees it, its label, and the models.

    library: library.json, its archives beside it; snapshots: pictures of the models; name: scene and object, no two
    alike; rank: of the cousin whose orientation is asked for; item, scene: what extraction found of the object, of all.
    """

    view: View
    label: str
    library: Path
    snapshots: Snapshots
    name: str = ""
    rank: int = 1
    item: SceneObject | None = None
    scene: Objects | None = None


class AbstainedError(Exception):
    """A judge does not decide. Then the order by distance holds, and cousins.json notes the reason.

    `chosen`: what it did decide on before, best first.
    """

    def __init__(self, reason: str, chosen: Sequence[Any] = ()) -> None:
        self.reason, self.chosen = reason, list(chosen)
        super().__init__(reason)


class Judge(Protocol):
    """Made from the options of `matching`. It gets both rankings, best first, and answers with its own.

    It may raise `AbstainedError`. `name`, if it has one, stands in cousins.json for the key of the config.
    """

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
    """The judges that the options name (one, if it decides both), and the models that they may look at."""

    def __init__(self, options: MatchingConfig, library: Path, snapshots: Snapshots) -> None:
        self.library, self.snapshots = library, snapshots
        names = dict.fromkeys((options.model_selection, options.orientation_selection))
        self._by_name = {name: load("judges", name)(options) for name in names}
        self.of_models: Judge = self._by_name[options.model_selection]
        self.of_orientations: Judge = self._by_name[options.orientation_selection]
        self.model_name = getattr(self.of_models, "name", options.model_selection)
        self.orientation_name = getattr(self.of_orientations, "name", options.orientation_selection)

    def question(self, view: View, item: SceneObject, scene: Objects) -> Question:
        """What is asked about one object."""
        name = f"{scene.scene}/{item.id}"
        return Question(view, item.label, self.library, self.snapshots, name, item=item, scene=scene)

    def summaries(self) -> list[str]:
        """What judges have to tell in the log when all is done (`summary`, if they have one)."""
        return [judge.summary() for judge in self._by_name.values() if hasattr(judge, "summary")]
