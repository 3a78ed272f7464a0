"""What a person says of a scene, in the place of what was chosen and found: models, what carries what, nudges."""

from collections.abc import Mapping

import numpy as np

from stages.contracts.corrections import Correction
from stages.contracts.cousins import Cousin
from stages.contracts.objects import SceneObject
from stages.generation.inputs import Inputs
from stages.generation.placed import Placed
from stages.generation.steps import told as logged
from stages.generation.support import stack_of


def leaders_first(inputs: Inputs) -> list[SceneObject]:
    """The objects, those with the model of another behind that one."""
    items, by_mask = inputs.objects.objects, {item.mask: item for item in inputs.objects.objects}

    def behind(item: SceneObject) -> int:
        like = inputs.said(item).like
        return 0 if like not in by_mask else 1 + behind(by_mask[like])

    return sorted(items, key=behind)


def stated(item: SceneObject, rank: int, inputs: Inputs, models: Mapping[int, str]) -> tuple[str, str] | None:
    """The asset that stands for an object in the scene of a rank because a person says so, and why; None: nobody does.

    Args:
        models: asset by mask value, of what stands in this scene already.
    """
    said = inputs.said(item)
    if said.like is not None and said.like in models:
        return models[said.like], "the model of what it is like, as a person says"
    if said.model is not None and (said.pinned or rank == 1):
        return said.model, "chosen by a person"
    return None


def left(ranked: list[Cousin], said: Correction) -> list[Cousin]:
    """The ranked cousins without those that a person banned, or chose for rank 1."""
    return [one for one in ranked if one.asset not in {said.model, *said.banned}]


def as_cousin(asset: str, category: str, ranked: list[Cousin]) -> Cousin:
    """Any asset as a cousin: as matching turned it, or as it turned the nearest one, for all assets face +x."""
    found = next((one for one in ranked if one.asset == asset), None)
    return found or ranked[0].model_copy(update={"asset": asset, "category": category})


def nudged(items: list[Placed], inputs: Inputs) -> list[Placed]:
    """The items after a person moved some, each with all that it carries."""
    moves = {item.id: inputs.said(item).nudge for item in inputs.objects.objects}
    supports, after = {item.id: item.support for item in items}, list(items)
    for item in items:
        if move := moves[item.id]:
            stack = stack_of(item.id, supports)
            after = [one.shifted(np.array([*move, 0.0])) if one.id in stack else one for one in after]
    return logged("moved by a person", items, after)
