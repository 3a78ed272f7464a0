"""Captions by a language model: what a thing is, its doors and drawers, what holds it (paper A.2, A.7)."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.cli import progress
from roomkin.stages.config.perception import SeeSection
from roomkin.stages.contracts.scenes import Held
from roomkin.stages.geometry.masks import pixel_bounds
from roomkin.stages.perception.classification.names import UNSURE, LikelyName, Names
from roomkin.stages.perception.classification.naming import Named
from roomkin.stages.perception.segmentation.proposal import Mask, RoomView
from roomkin.stages.plugins import load

Box = Sequence[float]


class Captioner(Protocol):
    """A language model that says what is in a picture (H, W, 3); `captioners/<name>.py` of a package defines one."""

    def list_labels(self, rgb: NDArray[np.uint8]) -> list[str]:
        """What is in the picture."""

    def caption(
        self, rgb: NDArray[np.uint8], box: Box, label: str, labels: Sequence[str], number: int
    ) -> dict[str, Any] | None:
        """Of the thing in a box label, articulated, doors, drawers; empty: not known; None: it is no whole thing."""

    def hold(
        self, rgb: NDArray[np.uint8], box: Box, walls: Sequence[Mask], label: str, number: int
    ) -> tuple[int, list[int]] | None:
        """How the thing in a box is held: type 1, 2, 3, and the walls that it touches, by places; None: unknown."""

    def summary(self) -> str:
        """What was asked, in a line."""


def make_captioner(options: SeeSection, model: Mapping[str, Any]) -> Captioner | None:
    """Who captions; None: nobody. `model`: the config section `vlm`."""
    captioner: Captioner | None = None if options.captions == "labels" else load("captioners", options.captions)(model)
    return captioner


def caption_things(captioner: Captioner, view: RoomView, things: Sequence[Named], options: SeeSection) -> list[Named]:
    """The things as they are captioned: what has a caption has a sure name; what is no whole thing is left out."""
    found = list(things)
    asked = [k for k, one in enumerate(things) if not one.left_out or one.left_out in UNSURE]
    for k in progress(asked, "objects"):
        one, label = things[k], word_of(things[k])
        said = captioner.caption(view.rgb, pixel_bounds(one.outlined.mask), label, options.labels, k + 1)
        if said is None:
            found[k] = replace(one, left_out="no whole thing, says the language model")
        elif said:
            names = Names([LikelyName(said["label"], 1.0)], 0.0)
            found[k] = replace(one, names=names, left_out="", stated=said)
    walls = view.surfaces.wall_masks
    if options.mounting == "vlm" and not walls:
        print("no wall is found: mounting by geometry")
    held = [k for k in asked if found[k].stated] if options.mounting == "vlm" and walls else []
    for k in progress(held, "mountings"):
        box, label = pixel_bounds(found[k].outlined.mask), word_of(found[k])
        how = captioner.hold(view.rgb, box, walls, label, k + 1)
        found[k] = replace(found[k], stated={**found[k].stated, "mounting": how})
    print(captioner.summary())
    return found


def word_of(one: Named) -> str:
    """What a thing is called: by a caption, by what detected it, by its looks."""
    words = one.outlined.words
    return str(one.stated.get("label") or max(words, key=words.__getitem__, default=one.names.proposals[0].name))


def state(said: Mapping[str, Any], walls: Sequence[int], shown: Collection[int]) -> dict[str, Any]:
    """A caption as an annotation has it; a mounting counts if all of its walls are seen.

    walls, shown: mask values of all walls, and of what has pixels left.
    """
    stated = {key: said[key] for key in ("articulated", "doors", "drawers") if key in said}
    if said.get("mounting"):
        kind, places = said["mounting"]
        touched = [walls[place] for place in places]
        if set(touched) <= set(shown):
            stated["mounting"] = Held.model_validate({"type": kind, "walls": touched})
        else:
            print(f"{said['label']}: mounting by geometry, its wall is all covered")
    return stated
