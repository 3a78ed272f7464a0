"""The cousins of one object, as judges or distance decide (paper A.6, B.1); things alike get the same models."""

from collections.abc import Callable

import numpy as np

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Library
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.contracts.parts import FRONTS
from roomkin.stages.matching.candidates import Candidates, count_gap
from roomkin.stages.matching.judges import Judges
from roomkin.stages.matching.ranking import Models, Orientations
from roomkin.stages.matching.snapshots import AbstainedError, Question, check_answer


def describe_counts(doors: int, drawers: int) -> str:
    """In words, e.g. `2 doors and no drawer`."""
    parts = zip((doors, drawers), FRONTS, strict=True)
    return " and ".join(f"{number or 'no'} {noun}{'s' * (number > 1)}" for number, noun in parts)


def note_differences(entry: ObjectCousins, item: SceneObject, library: Library) -> ObjectCousins:
    """The entry, where each cousin with other doors or drawers than were stated says so, and which model has them."""
    if item.doors + item.drawers == 0:
        return entry
    models = {one.id: one for one in library.assets}
    stated = describe_counts(item.doors, item.drawers)
    fitting = [one.rank for one in entry.cousins if count_gap(item, models[one.asset]) == 0]

    def describe_difference(one: Cousin) -> str:
        model = models[one.asset]
        if count_gap(item, model) == 0:
            return ""
        kind = one.category.replace("_", " ")
        if fitting:
            better = f"cousin {fitting[0]} has that"
        elif any(other.category == one.category and count_gap(item, other) == 0 for other in library.assets):
            better = f"another {kind} of the library has that"
        else:
            better = f"no {kind} of the library has that"
        return f"was said to have {stated}, the model has {describe_counts(model.doors, model.drawers)}; {better}"

    return entry.model_copy(
        update={"cousins": [one.model_copy(update={"differs": describe_difference(one)}) for one in entry.cousins]}
    )


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
        group = next((group for group in found if _is_alike(items[group[0]], item)), None)
        if group is None:
            found.append(group := [])
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


BY_DISTANCE = "distance"  # what decides where a judge does not


def decide_cousins(
    models: Models,
    orientations_of: Callable[[str], Orientations],
    candidates: Candidates,
    item: SceneObject,
    question: Question,
    judges: Judges,
    options: MatchingConfig,
) -> ObjectCousins:
    """Ranked cousins of one object, each with its own orientation, as the judges decide, or by distance.

    Args:
        models: the candidates by votes and by distance.
        orientations_of: those of an asset, likewise.
    """
    notes = [candidates.note] if candidates.note else []
    decided_by, orientation_decided_by = judges.model_name, judges.orientation_name
    by_votes, by_distance = models
    try:
        answer = judges.of_models.models(question, by_votes, by_distance)
        chosen = check_answer(judges.names[0], Candidate, answer, {one.asset for one in by_distance})
    except AbstainedError as abstained:
        chosen = abstained.chosen + [one for one in by_distance if one not in abstained.chosen]
        decided_by = decided_by if abstained.chosen else BY_DISTANCE
        notes.append(f"models from {len(abstained.chosen) + 1} on by distance: {abstained.reason}")
    judged = {one.asset: one for one in chosen}
    by_distance = [judged.get(one.asset, one) for one in by_distance]
    cousins = []
    for number, candidate in enumerate(chosen[: options.k_cousins], 1):
        voted, near = orientations_of(candidate.asset)
        asked = question._replace(rank=number)
        try:
            turns = judges.of_orientations.orientations(asked, candidate.asset, voted, near)
            orientations = check_answer(judges.names[1], Orientation, turns)
        except AbstainedError as abstained:
            orientations = abstained.chosen + [one for one in near if one not in abstained.chosen]
            orientation_decided_by = BY_DISTANCE if number == 1 and not abstained.chosen else orientation_decided_by
            notes.append(f"orientation of {candidate.asset} by distance: {abstained.reason}")
        orientations = orientations[: options.k_ori]
        cousins.append(
            Cousin(rank=number, **candidate.model_dump(), orientation=orientations[0], orientations=orientations)
        )
    doubts = [DoubtKind.LABEL.of(what=candidates.doubt)] if candidates.doubt else []
    return ObjectCousins(
        id=item.id, label=item.label, doubts=doubts, note="; ".join(notes), categories=candidates.categories,
        by_votes=by_votes, by_distance=by_distance, decided_by=decided_by,
        orientation_decided_by=orientation_decided_by, cousins=cousins,
    )  # fmt: skip
