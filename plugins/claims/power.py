"""Which effect a claim can show with its assets, starts and runs: tried on made-up truths, not on results.

The truths are as kind to the claim as can be: every asset and every start gains alike, and runs do not differ (but
where the claim is about that). What a claim cannot show there it can show nowhere.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

Sides = dict[str, pd.DataFrame]  # `twin`, `unseen` -> successes (policies, places)

TRIES, ENOUGH = 10, 8  # made-up results of a truth; of those the claim holds in so many at least: a power of 0.8
EFFECTS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)  # gains that are tried, smallest first
LARGE = 0.3  # a claim that shows no gain of this size is not asked; the paper's largest is 0.24 (drawers, 8 cousins)


def imagine(ours: Sides, theirs: Sides, plus: str, effect: float, rng: np.random.Generator) -> list[Sides]:
    """Successes of both sides by a truth with this effect, with the policies and places of the real ones.

    Args:
        ours, theirs: the real sides, of which only policies and places are read.
        plus: the mean in which ours gain; without it the claim is about how runs differ.
        effect: the gain of ours, from 0 to 1; over runs: the standard deviation of theirs, evenly spread; ours: none.
    """
    high, low = (1 + effect) / 2, (1 - effect) / 2

    def draw(side: pd.DataFrame, rates: float | np.ndarray) -> pd.DataFrame:
        opened = rng.random(side.shape) < np.broadcast_to(rates, len(side))[:, None]
        return pd.DataFrame(opened.astype(float), side.index, side.columns)

    if not plus:
        steps = np.linspace(-1, 1, len(next(iter(theirs.values()))))
        rates = 0.5 + effect * steps / max(steps.std(ddof=1), 1e-9)  # beyond 0 and 1: always, never
        return [
            {key: draw(side, 0.5) for key, side in ours.items()},
            {key: draw(side, rates) for key, side in theirs.items()},
        ]
    return [
        {key: draw(side, high) for key, side in ours.items()},
        {key: draw(side, low if key == plus else high) for key, side in theirs.items()},
    ]


def find_smallest(
    ours: Sides, theirs: Sides, plus: str, margin: float, holds: Callable[[Sides, Sides], bool], seed: int
) -> float:
    """The smallest effect that a claim shows in `ENOUGH` of `TRIES`; NaN: none, however large.

    Args:
        margin: by how much ours may be worse. Such a claim is tried where there is no effect and nobody fails: 0.
        holds: whether the claim holds of two sides.
    """
    for effect in (0.0,) if margin else EFFECTS:
        rng, held = np.random.default_rng(seed), 0
        for _ in range(TRIES):
            if margin:
                one, other = ({key: side * 0 + 1 for key, side in sides.items()} for sides in (ours, theirs))
            else:
                one, other = imagine(ours, theirs, plus, effect, rng)
            held += holds(one, other)
        if held >= ENOUGH:
            return effect
    return float("nan")
