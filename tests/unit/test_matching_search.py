"""Matching: the one-pass table against a literal reading of A.6, and the two search backends against each other."""

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.matching.ranking import embedding_distance, vote
from roomkin.stages.matching.search import distance_table
from roomkin.stages.plugins import list_available

Patches = list[NDArray[np.float32]]


def patches(
    seed: int, candidates: int = 12, queries: int = 40, columns: int = 16
) -> tuple[NDArray[np.float32], Patches]:
    rng = np.random.default_rng(seed)
    query = rng.normal(size=(queries, columns)).astype(np.float32)
    return query, [rng.normal(size=(rng.integers(5, 30), columns)).astype(np.float32) for _ in range(candidates)]


def literal_votes(query: NDArray[np.float32], candidates: Patches, rounds: int) -> list[tuple[int, int]]:
    """A.6 word by word: search all candidates' patches, count, take the top one, remove it, repeat."""
    left, picks = list(range(len(candidates))), []
    for _ in range(rounds):
        rows = np.concatenate([candidates[c] for c in left]).astype(np.float64)
        owner = np.concatenate([[c] * len(candidates[c]) for c in left])
        counts = dict.fromkeys(left, 0)
        for patch in query.astype(np.float64):
            counts[int(owner[((rows - patch) ** 2).sum(axis=1).argmin()])] += 1
        best = max(left, key=lambda c: counts[c])
        picks.append((best, counts[best]))
        left.remove(best)
    return picks


def literal_distance(query: NDArray[np.float32], candidate: NDArray[np.float32]) -> float:
    """A.6: mean distance of each patch to its nearest patch, the largest 10 % left out."""
    nearest = sorted(float(np.linalg.norm(candidate - patch, axis=1).min()) for patch in query)
    return float(np.mean(nearest[: len(nearest) - len(nearest) // 10]))


@pytest.mark.parametrize("search", list_available("searches"))
def test_one_pass_equals_the_literal_loop(search: str) -> None:
    for seed in range(3):
        query, candidates = patches(seed)
        table = distance_table(query, candidates.__getitem__, len(candidates), search).table
        picks = vote(table, np.arange(len(candidates)), 8)
        assert [tuple(pick) for pick in picks] == literal_votes(query, candidates, 8)
        expected = [literal_distance(query, candidate) for candidate in candidates]
        np.testing.assert_allclose(embedding_distance(table, 0.1), expected, rtol=1e-5)


@pytest.mark.parametrize("search", list_available("searches"))
def test_the_way_back_is_the_way_there_with_the_parts_swapped(search: str) -> None:
    query, candidates = patches(4)
    found = distance_table(query, candidates.__getitem__, len(candidates), search, both=True)
    for patch, back in zip(candidates, found.backward, strict=True):
        swapped = distance_table(patch, [query].__getitem__, 1, search).table[:, 0]
        np.testing.assert_allclose(back, swapped, rtol=1e-5)
    assert distance_table(query, candidates.__getitem__, len(candidates), search).backward == []


def test_equal_pictures_tie_and_the_first_wins() -> None:
    query, candidates = patches(7, candidates=3)
    table = distance_table(query, [*candidates, *candidates].__getitem__, 6, "torch").table
    np.testing.assert_array_equal(table[:, :3], table[:, 3:])
    assert vote(table, np.arange(6), 1)[0].group < 3


def test_distance_to_itself_is_exactly_zero() -> None:
    query, candidates = patches(8)
    for search in list_available("searches"):
        found = distance_table(query, [query * 7, query, *candidates].__getitem__, 3, search, nearest=1, both=True)
        assert embedding_distance(found.table, 0.1)[1] == 0.0
        assert not found.backward[1].any()


def test_a_group_wins_once_and_takes_all_its_pictures_along() -> None:
    table = np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [0.2, 0.1, 0.3]])
    assert [tuple(pick) for pick in vote(table, np.array([4, 4, 9]), 5)] == [(4, 2), (9, 3)]


def test_worst_tenth_is_left_out() -> None:
    table = np.arange(1, 21, dtype=float)[:, None]
    assert embedding_distance(table, 0.10)[0] == np.mean(np.arange(1, 19))
    assert embedding_distance(table, 0.0)[0] == np.mean(np.arange(1, 21))
    assert embedding_distance(table[:17], 0.10)[0] == np.mean(np.sort(table[:17, 0])[:16])  # 1.7 patches are one
    assert embedding_distance(table[:1], 0.10)[0] == 1.0
