"""Average linkage in rounds comes to what joining the best pair first comes to; pixels are joined by what links say."""

import itertools

import numpy as np
import pytest

from plugins.segmenter.joining import MOST, join_pixels, link_averages
from plugins.segmenter.network import NEIGHBOURS


def greedily(count: int, first: list[int], second: list[int], score: list[float], least: float) -> list[set[int]]:
    """Average linkage as textbooks have it: the best pair of regions first."""
    regions = [{k} for k in range(count)]
    while True:
        best, chosen = least, None
        for a, b in itertools.combinations(range(len(regions)), 2):
            links = [
                s
                for i, j, s in zip(first, second, score, strict=True)
                if (i in regions[a] and j in regions[b]) or (j in regions[a] and i in regions[b])
            ]
            if links and np.mean(links) > best:
                best, chosen = float(np.mean(links)), (a, b)
        if chosen is None:
            return regions
        a, b = chosen
        regions[a] |= regions.pop(b)


@pytest.mark.parametrize("seed", range(8))
def test_rounds_of_mutual_bests_are_average_linkage(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = np.array([pair for pair in itertools.combinations(range(14), 2) if rng.random() < 0.35])
    score = rng.normal(0, 1, len(pairs))
    found = link_averages(14, pairs[:, 0], pairs[:, 1], score, -0.1)
    true = greedily(14, pairs[:, 0].tolist(), pairs[:, 1].tolist(), score.tolist(), -0.1)
    assert sorted(sorted(np.flatnonzero(found == region).tolist()) for region in np.unique(found)) == sorted(
        sorted(region) for region in true
    )


def halves(votes_differ: bool, same_differ: bool) -> np.ndarray:
    """Regions of a square of two halves, of which links or votes say that they differ."""
    left = np.broadcast_to(np.arange(40) < 20, (40, 40))
    same = np.full((len(NEIGHBOURS), 40, 40), 2.0)
    if same_differ:
        for channel, (rows, columns) in enumerate(NEIGHBOURS):
            there = np.roll(left, (-rows, -columns), (0, 1))
            same[channel][left != there] = -MOST
    votes = np.zeros((40, 40, 3))
    votes[..., 0] = np.where(left, 0.0, 5.0 * votes_differ)
    free = np.ones((40, 40), bool)
    free[:3] = False
    return join_pixels(free, same, votes, np.full((40, 40), 0.5))


def test_pixels_of_one_thing_are_joined_and_of_two_are_not() -> None:
    one = halves(votes_differ=False, same_differ=False)
    assert (one[:3] == -1).all() and (one[3:] == 0).all()
    two = halves(votes_differ=False, same_differ=True)
    assert len(np.unique(two[3:])) == 2 and len(np.unique(two[3:, :20])) == 1


def test_votes_alone_lower_a_link() -> None:
    scores = [-1.0, 0.2]
    assert link_averages(2, np.array([0]), np.array([1]), np.array(scores[:1]), -0.5).tolist() == [0, 1]
    assert link_averages(2, np.array([0]), np.array([1]), np.array(scores[1:]), -0.5).tolist() == [0, 0]
