"""Who decides on model and orientation (paper A.6, B.1); the judges lie beside this file."""

from pathlib import Path

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.snapshots import AbstainedError, Judge, Question, Snapshots
from roomkin.stages.plugins import load

__all__ = ["AbstainedError", "Judge", "Judges", "Question"]


class Judges:
    """The judges that the options name (one, if it decides both), and the models that they may look at."""

    def __init__(self, options: MatchingConfig, library: Path, snapshots: Snapshots) -> None:
        self.library, self.snapshots = library, snapshots
        self.names = options.model_selection, options.orientation_selection
        names = dict.fromkeys(self.names)
        self._by_name = {name: load("judges", name)(options) for name in names}
        self.of_models: Judge = self._by_name[options.model_selection]
        self.of_orientations: Judge = self._by_name[options.orientation_selection]
        self.model_name = getattr(self.of_models, "name", options.model_selection)
        self.orientation_name = getattr(self.of_orientations, "name", options.orientation_selection)

    def question(self, view: ObjectView, item: SceneObject, scene: Objects) -> Question:
        """What is asked about one object."""
        name = f"{scene.scene}/{item.id}"
        return Question(view, item.label, self.library, self.snapshots, name, item=item, scene=scene)

    def summaries(self) -> list[str]:
        """What judges have to tell in the log when all is done (`summary`, if they have one)."""
        return [judge.summary() for judge in self._by_name.values() if hasattr(judge, "summary")]
