"""Models and orientations of one object, ranked by iterated patch voting and by embedding distance (paper A.6, B.1)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.matching import ComparisonOptions, MatchingConfig
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.candidates import Candidates, list_addends
from roomkin.stages.matching.encoders import PatchEncoder, column_weights, encode_rows, pool_patches, whole_weights
from roomkin.stages.matching.search import distance_table, load_search
from roomkin.stages.matching.snapshots import DIGITS
from roomkin.stages.matching.store import FeatureStore, Snapshot


class Pick(NamedTuple):
    """One round of voting: the group that won, and the votes of its winning picture."""

    group: int
    votes: int


def vote(table: NDArray[np.float64], groups: NDArray[np.intp], rounds: int) -> list[Pick]:
    """Iterated top-1 voting: every query patch votes for the picture with its nearest patch.

    Args:
        table: (Q, C) distance of each query patch to each candidate picture.
        groups: (C,) what each picture shows, e.g. the number of its model. The picture with most votes
            wins for its group, and all pictures of the group leave the next rounds.
        rounds: how many groups to pick; fewer if there are fewer.

    Ties, of patches as of votes, go to the picture that comes first.
    """
    remaining = table.copy()
    picks: list[Pick] = []
    for _ in range(min(rounds, len(np.unique(groups)))):
        votes = np.bincount(remaining.argmin(axis=1), minlength=len(groups))
        votes[np.isin(groups, [pick.group for pick in picks])] = -1  # a group that won is out, even with no votes left
        winner = int(votes.argmax())
        picks.append(Pick(int(groups[winner]), int(votes[winner])))
        remaining[:, groups == groups[winner]] = np.inf
    return picks


def embedding_distance(table: NDArray[np.float64], exclude_worst: float) -> NDArray[np.float64]:
    """Distance (C,) of the query to each picture: mean distance of its patches without the largest ones.

    `exclude_worst` is the share of patches left out (paper: 0.10), rounded down to whole patches.
    """
    kept = len(table) - int(exclude_worst * len(table))
    return np.partition(table, kept - 1, axis=0)[:kept].mean(axis=0)


Models = tuple[list[Candidate], list[Candidate]]  # by votes, by distance
Orientations = tuple[list[Orientation], list[Orientation]]  # likewise
MEDIAN_DISTANCE = 0.1  # of a shortlist's median candidate by its views as a whole: that by patches is about as large


class Query(NamedTuple):
    """Weighted patches (P, D) of one object, the weights (columns,) that made them, for the other side, and the
    object as one vector (W,)."""

    patches: NDArray[np.float32]
    weights: NDArray[np.float32]
    whole: NDArray[np.float16]


class Ranking(NamedTuple):
    """Both rankings of some groups of snapshots: distance (G,) per group, and the picks in order."""

    distances: NDArray[np.float64]
    picks: list[Pick]

    @property
    def nearest(self) -> list[int]:
        """Groups, nearest first; ties in their order."""
        return [int(group) for group in np.argsort(self.distances, kind="stable")]


def apply_weights(rows: NDArray[np.floating], weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Stored rows (P, columns) as vectors (P, D) to compare: weights applied, columns without weight left out."""
    used = weights > 0
    return rows[:, used].astype(np.float32) * weights[used]


def make_query(view: ObjectView, encoder: PatchEncoder, color: float = 0.0) -> Query | None:
    """Encode an object; normals count if half of its pixels or more have depth. None: it has no foreground patch.

    `color`: the weight of the patches' colors.
    """
    known = 0 if view.depth is None else np.count_nonzero(view.depth[view.mask])
    weights = column_weights(encoder, bool(2 * known >= np.count_nonzero(view.mask)), color)
    rows = encode_rows(encoder, [view])[0]  # as the other side is stored
    return Query(apply_weights(rows, weights), weights, pool_patches(rows)) if len(rows) else None


def compare(
    query: Query,
    rows: Callable[[int], NDArray[np.floating]],
    count: int,
    options: ComparisonOptions,
    nearest: int | None = None,
    symmetric: float = 0.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The table T (Q, count) of `distance_table` for `count` pictures of unweighted rows, and their distances (count,).

    `symmetric`: weight of the distance from a picture's patches to the query's (0: the other way alone).
    """

    def vectors(number: int) -> NDArray[np.float32]:
        return apply_weights(rows(number), query.weights)

    both_ways = distance_table(query.patches, vectors, count, options.search, nearest, both=symmetric > 0)
    distances = (1 - symmetric) * embedding_distance(both_ways.table, options.exclude_worst)
    if symmetric:
        back = [embedding_distance(way[:, None], options.exclude_worst)[0] for way in both_ways.backward]
        distances += symmetric * np.array(back)
    return both_ways.table, distances


def rank(
    query: Query,
    snapshots: Sequence[Snapshot],
    groups: Sequence[int],
    store: FeatureStore,
    options: ComparisonOptions,
    rounds: int,
    symmetric: float = 0.0,
    counted: int = 1,
) -> Ranking:
    """Compare the query with snapshots that are grouped, e.g. by model: a group is as near as its nearest snapshots.

    `symmetric`: weight of the distance from the snapshot's patches to the query's (0: the other way alone). `counted`:
    a group's distance is the mean over so many of its nearest snapshots.
    """
    owner = np.asarray(groups, dtype=np.intp)
    nearest = rounds * int(np.bincount(owner).max())  # entries per patch that some round of voting can look at
    table, single = compare(
        query, lambda number: store.rows(snapshots[number]), len(snapshots), options, nearest, symmetric
    )
    distances = np.array([np.sort(single[owner == group])[:counted].mean() for group in range(int(owner.max()) + 1)])
    return Ranking(distances.round(DIGITS), vote(table, owner, rounds))


def choose_views(store: FeatureStore, options: MatchingConfig) -> list[int]:
    """Views by which models are compared: the representative alone (paper), or some evenly spaced yaws."""
    count = min(options.views, len(store.yaws))
    return [round(k * len(store.yaws) / count) for k in range(count)] or [store.representative]


def shortlist(
    query: Query, candidates: Candidates, item: SceneObject, store: FeatureStore, options: MatchingConfig
) -> Candidates:
    """The `shortlist` candidates that are nearest by their views as a whole and by priors, in their order; 0: all."""
    assets = candidates.assets
    if not options.shortlist or len(assets) <= options.shortlist:
        return candidates
    views, factors = choose_views(store, options), whole_weights(query.weights)
    squared, _ = load_search(options.search)(
        apply_weights(query.whole[None], factors),
        lambda number: apply_weights(store.read_wholes(assets[number].id, views), factors),
        len(assets),
        False,
    )
    distances = MEDIAN_DISTANCE * squared[0] / max(float(np.median(squared[0])), 1e-9)
    distances += [sum(more.values()) for more in list_addends(item, candidates, options)]
    nearest = np.sort(np.argsort(distances, kind="stable")[: options.shortlist])
    return candidates._replace(assets=[assets[number] for number in nearest])


def rank_models(
    query: Query, candidates: Candidates, item: SceneObject, store: FeatureStore, options: MatchingConfig
) -> Models:
    """Candidates by votes (the top k_model) and by distance (all of them), to which priors may add."""
    views, assets = choose_views(store, options), candidates.assets
    snapshots = [Snapshot(entry.id, view) for entry in assets for view in views]
    groups = [number for number in range(len(assets)) for _ in views]
    ranking = rank(query, snapshots, groups, store, options, options.k_model, options.symmetric, options.nearest_views)
    votes = dict(ranking.picks)
    compared, addends = [], list_addends(item, candidates, options)
    for number, (entry, apart, more) in enumerate(zip(assets, ranking.distances.tolist(), addends, strict=True)):
        total, parts = round(apart + sum(more.values()), DIGITS), {"patches": apart} | more if more else {}
        seen = votes.get(number)
        compared.append(Candidate(asset=entry.id, category=entry.category, distance=total, parts=parts, votes=seen))
    return [compared[group] for group, _ in ranking.picks], sorted(compared, key=lambda one: one.distance)


def rank_by_priors(candidates: Candidates, item: SceneObject, options: MatchingConfig) -> Models:
    """All candidates by priors alone, where no picture is compared; ties in their order, and no votes."""
    known = [
        Candidate(asset=entry.id, category=entry.category, distance=round(sum(parts.values()), DIGITS), parts=parts)
        for entry, parts in zip(candidates.assets, list_addends(item, candidates, options), strict=True)
    ]
    return [], sorted(known, key=lambda one: one.distance)


def rank_orientations(query: Query, asset: str, store: FeatureStore, options: MatchingConfig) -> Orientations:
    """Views of an asset by votes (the top k_ori) and by distance (all of them)."""
    views = range(len(store.yaws))
    snapshots = [Snapshot(asset, view) for view in views]
    ranking = rank(query, snapshots, views, store, options, options.k_ori, options.symmetric)
    votes = dict(ranking.picks)
    orientations = [
        Orientation(yaw=store.yaws[view], distance=float(ranking.distances[view]), votes=votes.get(view))
        for view in views
    ]
    return [orientations[view] for view, _ in ranking.picks], [orientations[view] for view in ranking.nearest]
