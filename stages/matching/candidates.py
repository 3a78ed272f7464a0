"""The assets an object is compared with (paper A.7), and what is known of it besides its looks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from roomkin.stages.config.matching import CandidateOptions, MatchingConfig
from roomkin.stages.contracts import Library
from roomkin.stages.contracts.cousins import Candidate, CategoryMatch
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.contracts.parts import FRONTS, Panel
from roomkin.stages.matching.text_encoders import TextEncoder, find_doubt, find_nearest_categories

UNLIKELY = 0.1  # distance of a name that is e times less likely than the first; chosen
MIN_PROBABILITY = 1e-3  # probability of a name, below which it is as unlikely as this


class Candidates(NamedTuple):
    """Assets to compare, the categories they come from, what had to be relaxed to find enough, and what of the label
    was not understood."""

    assets: list[LibraryEntry]
    categories: list[CategoryMatch]
    note: str
    doubt: str = ""


def count_gap(item: SceneObject, entry: LibraryEntry) -> int:
    """|d doors| + |d drawers| (A.7)."""
    return abs(entry.doors - item.doors) + abs(entry.drawers - item.drawers)


def find_candidates(item: SceneObject, library: Library, text: TextEncoder, options: CandidateOptions) -> Candidates:
    """All assets of the k_cat nearest categories that suit the object.

    An articulated object is sought among assets with doors or drawers, and among those whose counts differ by at most
    `count_threshold` in all. Where this leaves fewer than `least_candidates`, the threshold is widened step by step,
    then the next nearest categories come in, and the note says so; assets without joints never come in that way.
    """
    by_counts = item.articulated and options.count_threshold is not None
    pool = [entry for entry in library.assets if not item.articulated or entry.doors + entry.drawers > 0]
    doubt = find_doubt(item.label, [entry.category for entry in pool], text)
    near = find_nearest_categories(item.label, [entry.category for entry in pool], len(pool), text)
    if doubt and near:
        doubt += f"; nearest: {', '.join(name for name, _ in near[:3])}"
    ordered = list_likely(item, near, text)
    categories = ordered[: options.k_cat]
    if pool and not categories:
        doubt = doubt or f"label '{item.label}' resembles no category, so all were searched"
        assets, notes = _with_counts(item, pool, options) if by_counts else (pool, [])
        return Candidates(assets, categories, "; ".join(notes), doubt)
    while len(_of(pool, categories)) < options.least_candidates and len(categories) < len(ordered):
        categories = ordered[: len(categories) + 1]
    more = [f"categories widened from {options.k_cat} to {len(categories)}"] if len(categories) > options.k_cat else []
    assets, notes = _with_counts(item, _of(pool, categories), options) if by_counts else (_of(pool, categories), [])
    return Candidates(assets, categories, "; ".join([*more, *notes]), doubt)


def list_likely(item: SceneObject, near: list[tuple[str, float]], text: TextEncoder) -> list[CategoryMatch]:
    """Categories with their distances, nearest first: by the label, or by the nearest of the names that it may have.

    A name that is less likely than the first is farther by `UNLIKELY` times the logarithm of how many times less.

    `near`: the categories by the label.
    """
    distances = dict(near)
    if item.names:
        categories, first = sorted(distances), max(item.names[0].probability, MIN_PROBABILITY)
        for one in item.names[1:]:
            more = UNLIKELY * float(np.log(first / max(one.probability, MIN_PROBABILITY)))
            for name, distance in find_nearest_categories(one.name, categories, len(categories), text):
                distances[name] = min(distances[name], round(distance + more, 6))
    ordered = sorted((distance, name) for name, distance in distances.items())
    return [CategoryMatch(category=name, distance=distance) for distance, name in ordered]


def _of(pool: list[LibraryEntry], categories: list[CategoryMatch]) -> list[LibraryEntry]:
    names = {match.category for match in categories}
    return [entry for entry in pool if entry.category in names]


def _with_counts(
    item: SceneObject, assets: list[LibraryEntry], options: CandidateOptions
) -> tuple[list[LibraryEntry], list[str]]:
    """Assets within `count_threshold`, widened until `least_candidates` are left or all of them; and what to note."""
    gaps = sorted(count_gap(item, entry) for entry in assets)
    asked = options.count_threshold or 0
    threshold = max([asked, *gaps[: options.least_candidates][-1:]])
    notes = [f"count_threshold widened from {asked} to {threshold}"] if threshold > asked else []
    return [entry for entry in assets if count_gap(item, entry) <= threshold], notes


SHIFT = 0.1  # share of a front by which all of its panels may lie off their stated places: boxes of things err


def panel_gap(item: SceneObject, entry: LibraryEntry) -> float:
    """Doors and drawers that are not at their stated places; by their numbers alone where either is not known."""
    return layout_gap(item.panels, entry.panels) if item.panels and entry.panels else float(count_gap(item, entry))


def layout_gap(stated: Sequence[Panel], own: Sequence[Panel]) -> float:
    """Sum of 1 - IoU over pairs of the same kind, paired so that it is least, and 1 for each without a partner.

    With all of them in place it is |d doors| + |d drawers| (`count_gap`). The model's may be laid over those that were
    said, all together and by `SHIFT` at most: the front that a person drew on is that of an estimated box.
    """
    ours, theirs = to_boxes(stated), to_boxes(own)
    return min(_gap(stated, ours, own, there) for there in (theirs, lay_over(theirs, ours)))


def _gap(
    stated: Sequence[Panel], ours: NDArray[np.float64], own: Sequence[Panel], theirs: NDArray[np.float64]
) -> float:
    """The sum with the boxes (N, 2, 2) and (M, 2, 2) of both."""
    gap = 0.0
    for kind in FRONTS:
        mine, others = [panel.kind == kind for panel in stated], [panel.kind == kind for panel in own]
        gaps = 1 - measure_overlaps(ours[mine], theirs[others])
        gap += float(gaps[linear_sum_assignment(gaps)].sum()) + abs(sum(mine) - sum(others))
    return gap


def to_boxes(panels: Sequence[Panel]) -> NDArray[np.float64]:
    """(N, 2, 2): across and up; from, to."""
    found = [[(panel.left, panel.right), (panel.bottom, panel.top)] for panel in panels]
    return np.array(found, dtype=float).reshape(-1, 2, 2)


def lay_over(own: NDArray[np.float64], stated: NDArray[np.float64]) -> NDArray[np.float64]:
    """Boxes (N, 2, 2) with the outline of all of them nearer to that of others, its edges by at most `SHIFT`."""
    if not len(own) or not len(stated):
        return own
    low, high = own[..., 0].min(axis=0), own[..., 1].max(axis=0)
    to_low = low + np.clip(stated[..., 0].min(axis=0) - low, -SHIFT, SHIFT)
    to_high = high + np.clip(stated[..., 1].max(axis=0) - high, -SHIFT, SHIFT)
    scale = np.maximum(to_high - to_low, 0) / (high - low)
    return np.asarray((own - low[:, None]) * scale[:, None] + to_low[:, None])


def measure_overlaps(ours: NDArray[np.float64], theirs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Intersection over union (N, M) of boxes (N, 2, 2) and (M, 2, 2)."""
    a, b = ours[:, None], theirs[None]
    shared = np.maximum(np.minimum(a[..., 1], b[..., 1]) - np.maximum(a[..., 0], b[..., 0]), 0).prod(axis=-1)
    areas = [(box[..., 1] - box[..., 0]).prod(axis=-1) for box in (a, b)]
    return np.asarray(shared / (areas[0] + areas[1] - shared))


def list_addends(item: SceneObject, candidates: Candidates, options: MatchingConfig) -> list[dict[str, float]]:
    """For every candidate what its distance grows by, by name; without those of weight 0."""
    labels, addends = {match.category: match.distance for match in candidates.categories}, []
    for entry in candidates.assets:
        parts = (
            ("label", options.label_weight, labels.get(entry.category, 0.0)),
            ("size", options.size_weight, size_gap(item, entry)),
            ("counts", options.count_weight, panel_gap(item, entry) if item.articulated else 0),
            ("place", options.place_weight, is_misplaced(item, entry)),
        )
        addends.append({name: weight * amount for name, weight, amount in parts if weight})
    return addends


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
