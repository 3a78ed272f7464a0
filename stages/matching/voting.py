"""Top-k by iterated voting, and the embedding distance (paper A.6), both from one table of patch distances."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


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
