"""Things that are alike get the same models: four chairs at a table, each half hidden, are seen better together."""

import numpy as np

from roomkin.stages.contracts.cousins import Cousin, ObjectCousins
from roomkin.stages.contracts.objects import SceneObject

# Logarithm: heights of alike things differ by less; widths and depths of what is half hidden differ by anything.
SAME_HEIGHT = 0.07


def agree_on_order(entries: list[ObjectCousins], items: list[SceneObject]) -> list[ObjectCousins]:
    """The entries, cousins of alike things in one order: by the mean of the scores that a model has with each of them.

    A model that is no cousin of one of them has, there, the score of its last. Where a judge gives no scores,
    everything stays as it is.

    Args:
        items: the objects of the entries, in their order.
    """
    result = list(entries)
    for group in group_alike(items):
        scores = {number: _scores(entries[number]) for number in group}
        members = [number for number in group if scores[number]]
        if len(members) < 2:
            continue
        models = {asset for number in members for asset in scores[number]}
        mean = {asset: np.mean([scores[n].get(asset, min(scores[n].values())) for n in members]) for asset in models}
        for n in members:
            others = ", ".join(entries[m].id for m in members if m != n)
            ordered = sorted(entries[n].cousins, key=lambda one: mean[one.asset], reverse=True)
            result[n] = _reorder(entries[n], ordered, f"models in one order with {others}, which is alike")
    return result


def group_alike(items: list[SceneObject]) -> list[list[int]]:
    """Numbers of the things that are alike: called and counted alike, as high, all hanging or none."""
    found: list[list[int]] = []
    for number, item in enumerate(items):
        like = (group for group in found if _is_alike(items[group[0]], item))
        group = next(like, None)
        if group is None:
            found.append([number])
        else:
            group.append(number)
    return [group for group in found if len(group) > 1]


def _is_alike(one: SceneObject, other: SceneObject) -> bool:
    if one.box is None or other.box is None or _state_mounting(one) != _state_mounting(other):
        return False
    return bool(abs(np.log(one.box.size[2] / other.box.size[2])) < SAME_HEIGHT)


def _state_mounting(item: SceneObject) -> tuple[str, int, int, bool]:
    hangs = item.mounting is not None and item.mounting.hangs
    return item.label, item.doors, item.drawers, hangs


def _scores(entry: ObjectCousins) -> dict[str, float]:
    """By model; empty if any has none."""
    scores = {one.asset: one.score for one in entry.cousins if one.score is not None}
    return scores if len(scores) == len(entry.cousins) else {}


def _reorder(entry: ObjectCousins, cousins: list[Cousin], note: str) -> ObjectCousins:
    ranked = [one.model_copy(update={"rank": rank}) for rank, one in enumerate(cousins, 1)]
    return entry.model_copy(update={"cousins": ranked, "note": "; ".join(filter(None, [entry.note, note]))})
