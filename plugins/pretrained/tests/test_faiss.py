"""The search `faiss` against that of the core."""

import numpy as np

from roomkin.stages.matching.ranking import vote
from roomkin.stages.matching.search import distance_table
from roomkin.stages.plugins import load
from tests.unit.test_matching_search import patches


def test_backends_agree_pick_for_pick_under_near_ties() -> None:
    """Candidates that are rounding-noise copies of each other, far from the origin: float32 alone disagrees here."""
    query, candidates = patches(5, candidates=4, queries=200, columns=64)
    rng = np.random.default_rng(6)
    shift = np.float32(3.0)
    copies = [c + shift + rng.normal(size=c.shape).astype(np.float32) * np.float32(3e-7) for c in candidates * 5]
    rows, count = copies.__getitem__, len(copies)
    plain = [load("searches", name)(query + shift, rows, count, False)[0] for name in ("torch", "faiss")]
    assert (plain[0].argmin(axis=1) != plain[1].argmin(axis=1)).any(), "the case is no test: plain float32 agrees"
    tables = [distance_table(query + shift, rows, count, name).table for name in ("torch", "faiss")]
    groups = np.arange(len(copies))
    assert vote(tables[0], groups, 10) == vote(tables[1], groups, 10)
