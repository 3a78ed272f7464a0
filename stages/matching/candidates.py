"""The assets an object is compared with: nearest categories, heuristics for articulated objects (paper A.7)."""

from typing import NamedTuple

from stages.config.matching import MatchingConfig
from stages.contracts import Library
from stages.contracts.cousins import CategoryMatch
from stages.contracts.library import LibraryEntry
from stages.contracts.objects import SceneObject
from stages.matching.text_encoders import TextEncoder, nearest_categories


class Candidates(NamedTuple):
    """Assets to compare, the categories they come from, and what had to be relaxed to find any."""

    assets: list[LibraryEntry]
    categories: list[CategoryMatch]
    note: str


def find_candidates(item: SceneObject, library: Library, text: TextEncoder, options: MatchingConfig) -> Candidates:
    """All assets of the k_cat nearest categories that suit the object.

    An articulated object is sought among assets with doors or drawers, and among those whose counts
    differ by at most `count_threshold` in all. A threshold that leaves nothing is widened until something
    is left, which the note says; assets without joints never come in that way.
    """
    by_counts = item.articulated and options.count_threshold is not None
    jointed = by_counts or (item.articulated and options.articulated_only)
    pool = [entry for entry in library.assets if not jointed or entry.doors + entry.drawers > 0]
    nearest = nearest_categories(item.label, [entry.category for entry in pool], options.k_cat, text)
    categories = [CategoryMatch(category=name, distance=distance) for name, distance in nearest]
    names = {category.category for category in categories}
    notes = []
    if not names and pool:
        notes.append(f"label '{item.label}' resembles no category, so all were searched")
        names = {entry.category for entry in pool}
    assets = [entry for entry in pool if entry.category in names]
    if not by_counts or not assets:
        return Candidates(assets, categories, "; ".join(notes))

    def gap(entry: LibraryEntry) -> int:
        return abs(entry.doors - item.doors) + abs(entry.drawers - item.drawers)

    asked = options.count_threshold or 0
    threshold = max(asked, min(gap(entry) for entry in assets))
    if threshold > asked:
        notes.append(f"count_threshold widened from {asked} to {threshold}")
    return Candidates([entry for entry in assets if gap(entry) <= threshold], categories, "; ".join(notes))
