"""How far unseen assets are from what training shows, and how often policies are expected to open them. Pure numpy."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stages.contracts.policies import TaskAsset

# Distance 1 is a front 1.42 times as wide, or a handle higher by 18 % of the front (docs/results/registered.md).
WIDTH, HEIGHT = 0.35, 0.18


class Curve(NamedTuple):
    """Expected success at a distance: the logistic function of `level - slope * distance`."""

    level: float
    slope: float

    def predict(self, distances: ArrayLike) -> NDArray[np.float64]:
        """Expected share of successes at each distance, (n,) in (0, 1); it falls with distance."""
        odds = np.exp(self.level - self.slope * np.asarray(distances, dtype=np.float64))
        return odds / (1 + odds)


# By task: fitted by `python -m benchmarks.forecast` on docs/results/registered/rollouts.tar.xz (720 pairs of asset and
# training set: twin, twin_randomised, cousins_8; network `lite`, 240 demonstrations); tests/test_forecast.py.
CURVES = {"door": Curve(1.888, 1.5292), "drawer": Curve(1.7782, 0.7025)}
# Root mean square error of a forecast mean over the 40 unseen assets of a room that no curve was fitted on.
ERRORS = {"door": 0.08, "drawer": 0.16}


def places(assets: Sequence[TaskAsset]) -> NDArray[np.float64]:
    """(n, 2): width of the panel and height of the handle on it, in units of distance, at the assets' nominal size."""
    return np.array([[math.log(a.panel_size[0]) / WIDTH, a.handle_height / HEIGHT] for a in assets]).reshape(-1, 2)


def distances(unseen: Sequence[TaskAsset], shown: Sequence[TaskAsset]) -> NDArray[np.float64]:
    """(n, m) distances of n unseen assets to m that training shows.

    All are at their nominal size: demonstrations stretch every training set, tests every asset, by about as much.
    """
    return np.linalg.norm(places(unseen)[:, None] - places(shown)[None], axis=2)


def measure_nearest(unseen: Sequence[TaskAsset], shown: Sequence[TaskAsset]) -> NDArray[np.float64]:
    """(n,) distances of unseen assets to the nearest that training shows, of which there is one at least."""
    return distances(unseen, shown).min(axis=1)


def forecast(task: str, unseen: Sequence[TaskAsset], shown: Sequence[TaskAsset]) -> NDArray[np.float64]:
    """(n,) expected shares of successes at unseen assets, of policies that are trained on `shown`.

    Args:
        task: one of `CURVES`.
    """
    return CURVES[task].predict(measure_nearest(unseen, shown))


def forecast_mean(task: str, unseen: Sequence[TaskAsset], shown: Sequence[TaskAsset]) -> float:
    """The mean of `forecast` over the unseen assets, of which there is one at least."""
    return float(forecast(task, unseen, shown).mean())


def measure_coverage(assets: Sequence[TaskAsset], shown: Sequence[TaskAsset], reach: float) -> float:
    """The share of the assets that lie within a distance of one that is shown."""
    return float((measure_nearest(assets, shown) <= reach).mean())


class Most(NamedTuple):
    """Shares of assets: what a set picked greedily covers, and more than what no set of that size does."""

    greedy: float
    bound: float


def most_covered(assets: Sequence[TaskAsset], count: int, reach: float) -> Most:
    """What `count` of the assets can cover of all of them.

    A set covers at most what another covers, and beside that what each of its members alone would add: so after every
    step of the greedy choice there is a bound, and the least of them is returned.
    """
    near = distances(assets, assets) <= reach
    found, bound = np.zeros(len(assets), dtype=bool), float(len(assets))
    for _ in range(count + 1):
        gains = (near & ~found[:, None]).sum(axis=0)
        bound = min(bound, found.sum() + np.sort(gains)[-count:].sum())
        greedy, found = found.sum(), found | near[:, gains.argmax()]
    return Most(float(greedy) / len(assets), float(bound) / len(assets))


def find_isolated(assets: Sequence[TaskAsset], reach: float) -> list[TaskAsset]:
    """The assets with none of another family within a distance: nothing but their own family shows them."""
    families = np.array([asset.family for asset in assets])
    others = (distances(assets, assets) <= reach) & (families[:, None] != families[None])
    return [asset for asset, seen in zip(assets, others.any(axis=1), strict=True) if not seen]
