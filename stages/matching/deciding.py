"""The cousins of one object, as the judges decide on models and orientations, or by distance (paper A.6, B.1)."""

from collections.abc import Callable

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.candidates import Candidates
from roomkin.stages.matching.judges import Judges
from roomkin.stages.matching.question import AbstainedError, Question, check_answer
from roomkin.stages.matching.ranking import Models, Orientations

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
    return ObjectCousins(
        id=item.id,
        label=item.label,
        doubts=[DoubtKind.LABEL.of(what=candidates.doubt)] if candidates.doubt else [],
        note="; ".join(notes),
        categories=candidates.categories,
        by_votes=by_votes,
        by_distance=by_distance,
        decided_by=decided_by,
        orientation_decided_by=orientation_decided_by,
        cousins=cousins,
    )
