"""The assets an object is compared with: nearest categories, heuristics for articulated objects (paper A.7)."""

from typing import NamedTuple

import numpy as np

from roomkin.stages.config.matching import CandidateOptions
from roomkin.stages.contracts import Library
from roomkin.stages.contracts.cousins import CategoryMatch
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import SceneObject
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
    return [
        CategoryMatch(category=name, distance=distance)
        for name, distance in sorted(distances.items(), key=_by_distance)
    ]


def _by_distance(pair: tuple[str, float]) -> tuple[float, str]:
    return pair[1], pair[0]


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
