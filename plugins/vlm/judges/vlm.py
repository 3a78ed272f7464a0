"""Judge `vlm`: a language model that sees chooses among the nearest by distance (paper B.1, GPT selection)."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, create_model

from roomkin.plugins.vlm.ask import Asker, NoAnswerError
from roomkin.plugins.vlm.package import VlmConfig
from roomkin.plugins.vlm.prompt import Prompt, draw_box
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import NO_MODEL, Candidate, Orientation
from roomkin.stages.geometry.frames import wrap_angle
from roomkin.stages.geometry.masks import darken_rest, pixel_bounds
from roomkin.stages.matching.snapshots import AbstainedError, Question
from roomkin.stages.matching.snapshots import Judge as JudgeOf
from roomkin.stages.plugins import load

NONE = "none"
FRAME_GAP = 4  # pixels between the object and its box
SYSTEM = (
    "You compare an object in a picture of a room with pictures of 3D models. Look closely, and say only what you can "
    "see. You answer with one JSON object and nothing else."
)
OBJECT = "The room. The object in question, labelled '{label}', is in the red box."
ALONE = "The object alone; what is not part of it is darkened, and other things may hide parts of it."
WHICH_MODEL = (
    "Which candidate is most like the object in its geometry? A candidate may be stretched along its width, depth and "
    "height as a whole and painted otherwise, and it stands before you turned some way: size, proportions, colour and "
    "orientation do not count. What counts is what it is made of: which parts, how many, and where. If there are doors "
    "or drawers, their number, layout and handles come first."
)
WHICH_ORIENTATION = (
    "The candidates are one 3D model, turned about its vertical axis. In which of them is it turned as the object is "
    "seen here: front, sides and back towards the viewer in the same way? Size, proportions and colour do not count, "
    "and the model need not be equal to the object: go by what makes out its front, e.g. doors, drawers, a backrest."
)
ANSWER = (
    'Answer {{"reason": "one short sentence", "choice": "number of the candidate"}}, the number being one of '
    '{numbers}; or "choice": "none" if the pictures do not let you tell.'
)


class Judge:
    """It chooses as often as `vlm.choices` says, each time among what is left; the others follow by distance."""

    def __init__(self, options: Any) -> None:
        """`options`: a `MatchingConfig` with the section `vlm`."""
        self.options: MatchingConfig = options
        self.model: VlmConfig = options.vlm
        self.asker = Asker(self.model)
        stands_in = self.model.stand_in and self.model.key_env and not self.asker.endpoint.key
        self.stand_in: JudgeOf | None = load("judges", self.model.stand_in)(options) if stands_in else None
        self.name = f"{self.model.stand_in}, {NO_MODEL}" if stands_in else f"vlm {self.model.model}"

    def models(self, question: Question, by_votes: list[Candidate], by_distance: list[Candidate]) -> list[Candidate]:
        """The best of the k_model nearest, by their representative snapshots, then the best of those left ..."""
        left, chosen = by_distance[: self.options.k_model], list[Candidate]()
        count = min(self.model.choices, self.options.k_cousins, len(left))
        while len(chosen) < count:
            names = [candidate.asset for candidate in left]
            pictures = [question.snapshots.views(name)[-1].rgb for name in names]
            find = partial(self._find_model, question, [*left])
            chosen.append(left.pop(self._choice(question, WHICH_MODEL, pictures, names, "model", chosen, find)))
        return chosen + [candidate for candidate in by_distance if candidate not in chosen]

    def orientations(
        self, question: Question, asset: str, by_votes: list[Orientation], by_distance: list[Orientation]
    ) -> list[Orientation]:
        """The best of the k_ori nearest, then the others."""
        if question.rank > self.model.choices:
            return by_distance
        left = by_distance[: self.options.k_ori]
        pictures = [question.snapshots.picture(asset, orientation.yaw) for orientation in left]
        names = [f"{np.degrees(orientation.yaw):.0f} degrees" for orientation in left]
        find = partial(self._find_orientation, question, asset, left)
        best = left[self._choice(question, WHICH_ORIENTATION, pictures, names, f"orientation of {asset}", [], find)]
        return [best] + [orientation for orientation in by_distance if orientation != best]

    def summary(self) -> str:
        """The question, for the log."""
        return self.asker.summary(self.name if self.stand_in else "")

    def _choice(
        self,
        question: Question,
        task: str,
        pictures: Sequence[NDArray[np.uint8]],
        names: Sequence[str],
        what: str,
        chosen: Sequence[Any],
        find: Callable[[], int],
    ) -> int:
        """Place of the candidate that the model, or by `find` its stand-in, chooses; one alone needs no asking.

        Raises:
            AbstainedError: it chooses none, or gives no answer.
        """
        if len(pictures) == 1:
            return 0
        numbers = [str(number) for number in range(1, len(pictures) + 1)]
        label, (x0, y0, x1, y1) = question.label.replace("'", ""), pixel_bounds(question.view.mask)
        around = (x0 - FRAME_GAP, y0 - FRAME_GAP, x1 + FRAME_GAP - 1, y1 + FRAME_GAP - 1)
        parts: list[str | NDArray[np.uint8]] = [OBJECT.format(label=label), draw_box(question.view.rgb, around)]
        parts += [ALONE, darken_rest(question.view)]
        for number, picture in zip(numbers, pictures, strict=True):
            parts += [f"Candidate {number}:", picture]
        parts += [task, ANSWER.format(numbers=", ".join(numbers))]
        named = dict(zip(numbers, names, strict=True))
        choice, about = make_choice(numbers), f"{question.name}: {what}"
        stand_in = (self.name, lambda: choice(reason=self.name, choice=numbers[find()])) if self.stand_in else None
        try:
            answer: Any = self.asker.ask(Prompt(SYSTEM, parts), choice, about, named, stand_in)
        except NoAnswerError as error:
            raise AbstainedError(f"{self.name}: {error}", chosen) from None
        if answer.choice == NONE:
            raise AbstainedError(f"{self.name} chooses none", chosen)
        return numbers.index(answer.choice)

    def _find_model(self, question: Question, left: list[Candidate]) -> int:
        """Place of the stand-in's first."""
        assert self.stand_in is not None
        return [one.asset for one in left].index(self.stand_in.models(question, left, left)[0].asset)

    def _find_orientation(self, question: Question, asset: str, left: list[Orientation]) -> int:
        """Place of what is nearest to how the stand-in turns it."""
        assert self.stand_in is not None
        yaw = self.stand_in.orientations(question, asset, left, left)[0].yaw
        return min(range(len(left)), key=lambda number: abs(wrap_angle(left[number].yaw - yaw)))


def make_choice(numbers: Sequence[str]) -> type[BaseModel]:
    """The schema of an answer: a reason, then one of the numbers or none."""
    choice: Any = Literal[(*numbers, NONE)]
    return create_model("Choice", __config__=ConfigDict(extra="forbid"), reason=(str, ...), choice=(choice, ...))
