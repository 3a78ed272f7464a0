"""What is in the picture, by a language model that sees: a list, then every found object again (paper A.2, A.7)."""

from collections.abc import Sequence
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, create_model

from stages.vlm.ask import Asker, NoAnswerError
from stages.vlm.prompt import Prompt

NONE = "none"
RED = (255, 0, 0)
SYSTEM = (
    "You look at a picture of a room and say what things stand, lie or hang in it. Say only what you can see. You "
    "answer with one JSON object and nothing else."
)
LIST = (
    "List the kinds of things in this picture: furniture, appliances and loose objects, each by a short common noun in "
    "the singular, each kind once. Whole things only, no parts such as doors, drawers or handles; no floor, walls, "
    'ceiling, windows or doors of the room. Answer {"labels": ["cabinet", "mug"]}.'
)
LOOK = (
    "Look at the thing in the red box. Which of these is it: {labels}? 'none' if it is none of them, only a part of a "
    "thing, or several things at once. Does it open by doors (hinged) or drawers (sliding)? Count those that you see "
    'of this thing alone. Answer {{"label": "cabinet", "articulated": true, "doors": 2, "drawers": 1}}.'
)


class Listed(BaseModel):
    """Kinds of things in a picture."""

    model_config = ConfigDict(extra="forbid")
    labels: list[str]


class Looked(BaseModel):
    """One thing; `label` is one of those listed, or none."""

    model_config = ConfigDict(extra="forbid")
    label: str
    articulated: bool
    doors: int = Field(ge=0, le=20)
    drawers: int = Field(ge=0, le=20)


def listed(asker: Asker, rgb: NDArray[np.uint8]) -> list[str]:
    """Labels of what is in the picture, in the order given, lower case.

    Raises:
        NoAnswerError: there is no answer that can be used.
    """
    answer = asker.ask(Prompt(SYSTEM, [rgb, LIST]), Listed, "what is in the picture")
    labels = [" ".join(label.lower().replace(".", " ").split())[:60] for label in answer.labels]
    labels = [label for label in dict.fromkeys(labels) if label and label != NONE]
    if not labels:
        raise NoAnswerError("it lists nothing")
    return labels


def looked(asker: Asker, rgb: NDArray[np.uint8], box: Sequence[float], labels: Sequence[str], about: str) -> Looked:
    """What the thing in a box is.

    Raises:
        NoAnswerError: there is no answer that can be used.
    """
    shown = rgb.copy()
    x0, y0, x1, y1 = (round(value) for value in box)
    cv2.rectangle(shown, (x0, y0), (x1, y1), RED, max(2, round(max(rgb.shape) / 300)))
    choice: Any = Literal[(*labels, NONE)]
    answer = create_model("Look", __base__=Looked, label=(choice, ...))
    found = asker.ask(Prompt(SYSTEM, [shown, LOOK.format(labels=", ".join(labels))]), answer, about)
    panels = found.doors + found.drawers > 0
    return found.model_copy(update={"articulated": found.articulated or panels})
