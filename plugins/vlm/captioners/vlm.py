"""Captioner `vlm`: labels by a language model, of the whole picture, then of each object (paper A.2, A.7)."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator

from roomkin.plugins.vlm.ask import Asker, NoAnswerError
from roomkin.plugins.vlm.package import VlmConfig
from roomkin.plugins.vlm.prompt import Prompt, draw_box
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.perception.write import draw_numbers

NONE = "none"
SYSTEM_PROMPT = (
    "You look at a picture of a room and say what things stand, lie or hang in it. Say only what you can see. You "
    "answer with one JSON object and nothing else."
)
LABELS_PROMPT = (
    "List the kinds of things in this picture: furniture, appliances and loose objects, each by a short common noun in "
    "the singular, each kind once. Whole things only, no parts such as doors, drawers or handles; no floor, walls, "
    'ceiling, windows or doors of the room. Answer {"labels": ["cabinet", "mug"]}.'
)
OBJECT_PROMPT = (
    "Look at the thing in the red box. Which of these is it: {labels}? 'none' if it is none of them, only a part of a "
    "thing, or several things at once. Does it open by doors (hinged) or drawers (sliding)? Count those that you see "
    'of this thing alone. Answer {{"label": "cabinet", "articulated": true, "doors": 2, "drawers": 1}}.'
)
MOUNTING_PROMPT = (
    "The first picture has a thing in a red box, {label}; in the second the walls of the room are tinted, and numbered "
    "from 1 to {count}. How is the thing held? 'hangs': it is fixed on a wall, with nothing closely beneath it. "
    "'stands': it stands on the floor or on another thing and touches no wall. 'stands_at_wall': it is not fixed on a "
    "wall, but one of its faces touches one, as a bookshelf on the floor or a microwave on a cabinet does. For 'hangs' "
    "and 'stands_at_wall' name the walls that it touches, the one at its back first. "
    'Answer {{"held": "stands_at_wall", "walls": [1]}}.'
)
MOUNTINGS = ("hangs", "stands", "stands_at_wall")  # of mounting, from 1


class LabelsAnswer(BaseModel):
    """Kinds of things in a picture."""

    model_config = ConfigDict(extra="forbid")
    labels: list[str]


class ObjectAnswer(BaseModel):
    """One thing; `label` is one of those listed, or none."""

    model_config = ConfigDict(extra="forbid")
    label: str
    articulated: bool
    doors: int = Field(ge=0, le=20)
    drawers: int = Field(ge=0, le=20)


class MountingAnswer(BaseModel):
    """How one thing is held; `walls` by their numbers, and only of what touches one."""

    model_config = ConfigDict(extra="forbid")
    held: Literal["hangs", "stands", "stands_at_wall"]
    walls: list[int]

    @model_validator(mode="after")
    def _at_walls(self) -> "MountingAnswer":
        if (self.held == "stands") == bool(self.walls):
            raise ValueError("walls: named for what touches a wall, and only for that")
        return self


class Captioner:
    """A language model that says what is in a picture; see `roomkin.stages.perception.see`."""

    def __init__(self, options: Mapping[str, Any]) -> None:
        """`options`: the config section `vlm`."""
        self.asker = Asker(VlmConfig.model_validate(dict(options)))

    def list_labels(self, rgb: NDArray[np.uint8]) -> list[str]:
        """Labels of what is in a picture (H, W, 3).

        Raises:
            InputError: there is no answer that can be used.
        """
        model = self.asker.options
        try:
            answer = self.asker.ask(Prompt(SYSTEM_PROMPT, [rgb, LABELS_PROMPT]), LabelsAnswer, "what is in the picture")
            labels = [escape_control(" ".join(label.lower().replace(".", " ").split())[:60]) for label in answer.labels]
            labels = [label for label in dict.fromkeys(labels) if label and label != NONE]
            if not labels:
                raise NoAnswerError("it lists nothing")
        except NoAnswerError as error:
            what = f"says not what is in the picture ({error})."
            mend = "perception.captions: labels needs no language model"
            raise InputError(model.url, what, mend, code="E-VLM-ANSWER") from None
        print(f"{model.model} lists {', '.join(labels)}")
        return labels

    def caption(
        self, rgb: NDArray[np.uint8], box: Sequence[float], label: str, labels: Sequence[str], number: int
    ) -> dict[str, Any] | None:
        """What the thing in a box is, its doors and drawers; empty: no usable answer; None: it is no whole thing.

        Args:
            box: x0, y0, x1, y1.
            label: what it was taken for.
            labels: those of the picture.
            number: of the thing, for people.
        """
        about, name = f"object {number}, {label}", self.asker.options.model
        choice: Any = Literal[(*labels, NONE)]
        form = create_model("Look", __base__=ObjectAnswer, label=(choice, ...))
        prompt = Prompt(SYSTEM_PROMPT, [draw_box(rgb, box), OBJECT_PROMPT.format(labels=", ".join(labels))])
        try:
            answer = self.asker.ask(prompt, form, about)
        except NoAnswerError as error:
            print(f"{about}: no answer ({error}): its label stays")
            return {}
        if answer.label == NONE:
            print(f"{about}: is no whole object, says {name}: left out")
            return None
        if answer.label != label:
            print(f"{about}: is a {answer.label}, says {name}")
        return answer.model_dump() | {"articulated": answer.articulated or answer.doors + answer.drawers > 0}

    def hold(
        self, rgb: NDArray[np.uint8], box: Sequence[float], walls: Sequence[NDArray[np.bool_]], label: str, number: int
    ) -> tuple[int, list[int]] | None:
        """How the thing in a box is held: type 1, 2, 3, and the walls (H, W) that it touches, by their places; None: no
        usable answer."""
        about = f"object {number}, {label}: mounting"
        which: Any = list[Literal[tuple(range(1, len(walls) + 1))]]  # type: ignore[misc]
        form = create_model("Held", __base__=MountingAnswer, walls=(which, ...))
        text = MOUNTING_PROMPT.format(label=label, count=len(walls))
        prompt = Prompt(SYSTEM_PROMPT, [draw_box(rgb, box), draw_numbers(rgb, walls), text])
        try:
            found = self.asker.ask(prompt, form, about)
        except NoAnswerError as error:
            print(f"{about} by geometry, no answer ({error})")
            return None
        return 1 + MOUNTINGS.index(found.held), [wall - 1 for wall in dict.fromkeys(found.walls)]

    def summary(self) -> str:
        """What was asked, in a line."""
        return self.asker.summary()
