"""What is known of an object besides its looks, as addends to the distance of a model: label, size, counts, place.

None of it is in the paper; every addend has a weight, and weight 0 leaves it out. Size and place use that the rooms of
this workflow are furnished with models at about their own size and where they belong: docs/matching.md says how much
of the figures that is.
"""

import numpy as np

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.cousins import Candidate
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.candidates import Candidates
from roomkin.stages.matching.panels import panel_gap


def list_addends(item: SceneObject, candidates: Candidates, options: MatchingConfig) -> list[dict[str, float]]:
    """For every candidate what its distance grows by, by name; without those of weight 0."""
    labels = {match.category: match.distance for match in candidates.categories}
    return [
        {
            name: weight * amount
            for name, weight, amount in (
                ("label", options.label_weight, labels.get(entry.category, 0.0)),
                ("size", options.size_weight, size_gap(item, entry)),
                ("counts", options.count_weight, panel_gap(item, entry) if item.articulated else 0),
                ("place", options.place_weight, is_misplaced(item, entry)),
            )
            if weight
        }
        for entry in candidates.assets
    ]


def sum_priors(candidate: Candidate) -> float:
    """What a model's distance is the sum of besides patches."""
    return sum(part for name, part in candidate.parts.items() if name != "patches")


def size_gap(item: SceneObject, entry: LibraryEntry) -> float:
    """Mean |log ratio| of the extents of the object's box and the model's own, in the better of two orientations.

    0 where either is not known.
    """
    if item.box is None or entry.size is None:
        return 0.0
    seen, own = np.log(item.box.size), np.log(entry.size)
    return float(min(np.abs(seen - own).mean(), np.abs(seen - own[[1, 0, 2]]).mean()))


def is_misplaced(item: SceneObject, entry: LibraryEntry) -> float:
    """1 if the object hangs on a wall and the model does not, or the reverse; 0 where either is not known."""
    if item.mounting is None or entry.placement is None:
        return 0.0
    return float(item.mounting.hangs != (entry.placement == "wall"))
