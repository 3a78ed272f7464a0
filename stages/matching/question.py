"""What a judge is asked and answers; the judges lie in `judges/`."""

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeVar

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import InputError, Objects
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.snapshots import Snapshots

T = TypeVar("T")
DIGITS = 4  # of distances and scores: beyond them backends differ, so what is equal up to here is a tie


class Question(NamedTuple):
    """What a judge may look at: the object as the camera sees it, its label, and the models.

    library: library.json, its archives beside it; snapshots: pictures of the models; name: scene and object, no two
    alike; rank: of the cousin whose orientation is asked for; item, scene: what extraction found of the object, of all.
    """

    view: ObjectView
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


def check_answer(judge: str, kind: type[T], answer: object, shown: Collection[str] | None = None) -> list[T]:
    """The answer of a judge: a list of a kind that is not empty; if something was `shown`, some of that, none twice.

    Raises:
        InputError: it is not; the judge is named.
    """
    where, mend = f"judge {judge}", "docs/extending.md says what a judge gives"
    if not isinstance(answer, list | tuple) or not answer or not all(isinstance(each, kind) for each in answer):
        raise InputError(where, f"gives {repr(answer)[:80]}, no list of {kind.__name__}.", mend, code="E-JUDGE-ANSWER")
    if shown is not None:
        names = [str(each.asset) for each in answer]  # type: ignore[attr-defined]
        for number, name in enumerate(names):
            if name not in shown or name in names[:number]:
                why = f"{name} twice" if name in shown else f"{name}, which it was not shown"
                raise InputError(where, f"gives {why}.", mend, code="E-JUDGE-ANSWER")
    return list(answer)
