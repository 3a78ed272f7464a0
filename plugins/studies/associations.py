"""Which unseen assets policies open: rank correlations of success with what is known of an asset."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from roomkin.plugins.claims.assets import of_splits
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.tables.intervals import PLACE, place_weights, quantiles
from roomkin.stages.tables.rows import ROW, SKILL, in_order, records, row_title, set_key, title
from roomkin.stages.tables.text import TextTable, cell

TRAITS = {
    "feature_distance": "distance to the twin",
    "handle_length": "length of the handle",
    "handle_height": "height of the handle on the front",
    "coverage": "coverage by the training set",
}
COLUMNS = [*ROW, "trait", "training_set", "assets", "families", "correlation", "low", "high"]


class ShownAssets(NamedTuple):
    """The assets of a training set, and the factors between which demonstrations stretch each axis of them."""

    assets: Sequence[TaskAsset]
    factors: tuple[float, float]

    def coverage(self, asset: TaskAsset) -> float:
        """The share of four figures of an asset that lie between the least and the greatest of the training set.

        They are width and height of the panel, length of the handle, which demonstrations stretch, and its height on
        the front, which they keep.
        """
        low, high = self.factors
        figures = np.array([[*each.panel_size, each.handle_length, each.handle_height] for each in self.assets])
        least, most = figures.min(axis=0) * [low, low, low, 1], figures.max(axis=0) * [high, high, high, 1]
        own = np.array([*asset.panel_size, asset.handle_length, asset.handle_height])
        return float(((own >= least) & (own <= most)).mean())


def traits(tested: Sequence[TaskAsset], sets: Mapping[tuple[str, int], ShownAssets]) -> pd.DataFrame:
    """A row per training set, seed and unseen asset with what no row of `Rollout` tells: `handle_height`, `coverage`.

    Args:
        sets: by name and seed, as sets that are drawn by chance are others for every seed.
    """
    return pd.DataFrame(
        [
            {"training_set": name, "seed": seed, "asset": asset.asset, "handle_height": asset.handle_height}
            | {"coverage": shown.coverage(asset)}
            for (name, seed), shown in sets.items()
            for asset in tested
        ],
        columns=["training_set", "seed", "asset", "handle_height", "coverage"],
    )


def build(rollouts: pd.DataFrame, options: TablesConfig) -> pd.DataFrame:
    """A row per target, policy, trait and training set with `COLUMNS`: Spearman's correlation over assets.

    Its interval is a bootstrap over families of assets; ranks are those among all assets.

    Args:
        rollouts: rows of `Rollout` with the columns of `TRAITS`.
    """
    policies = of_splits(rollouts)
    policies = policies[policies["training_set"] != SKILL]
    rows = []
    for (*row, name), part in policies.groupby([*ROW, "training_set"], sort=False):
        # what is known of an asset is the same in all its rows, but for the coverage by sets that differ with the seed
        known = {trait: (trait, "mean" if trait == "coverage" else "first") for trait in TRAITS}
        each = part.groupby(["family", "asset"]).agg(success=("success", "mean"), **known)
        places = pd.MultiIndex.from_tuples([(*key, 0) for key in each.index], names=PLACE)
        weights = place_weights(places, options.bootstrap_samples, np.random.default_rng(options.seed))
        ranks = each.rank().to_numpy()
        for column, trait in enumerate(TRAITS, start=1):
            pair = ranks[:, [0, column]]
            low, high = quantiles(_correlation(pair, weights), options)
            rows.append(
                dict(zip(ROW, row, strict=True))
                | {"trait": trait, "training_set": name, "assets": len(each), "low": low, "high": high}
                | {"families": each.index.get_level_values("family").nunique()}
                | {"correlation": float(_correlation(pair, np.ones((1, len(each))))[0])}
            )
    return in_order(pd.DataFrame(rows, columns=COLUMNS))


def _correlation(pairs: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(S,) Pearson correlations of pairs (n, 2) under weights (S, n); 0 where a side does not vary."""
    weights = weights / weights.sum(axis=1, keepdims=True)
    away = pairs[None] - (weights @ pairs)[:, None]
    variances = (weights[..., None] * away**2).sum(axis=1)
    both = (weights * away.prod(axis=2)).sum(axis=1)
    scale = np.sqrt(variances.prod(axis=1))
    return np.divide(both, scale, out=np.zeros_like(both), where=scale > 1e-12)


def format_signed(value: float) -> str:
    """A correlation with its sign."""
    return f"{value:+.2f}".replace("-", "−")


def associations_table(table: pd.DataFrame) -> TextTable:
    """The rows as text: a row per target, policy and trait, a column per training set."""
    sets = sorted(table["training_set"].unique(), key=set_key)
    rows = []
    for (_, trait), part in table.groupby([table[ROW].agg("/".join, axis=1), "trait"], sort=False):
        line = {row["training_set"]: row for row in records(part)}
        texts = [cell(format_signed(line[n]["correlation"]), _remark(line[n])) if n in line else "" for n in sets]
        rows.append([row_title(records(part)[0]), TRAITS[str(trait)], *texts])
    return TextTable(
        "associations",
        "Which unseen assets are opened: Spearman's correlation of success with what is known of an asset.",
        ["Task", "Success against", *map(title, sets)],
        rows,
        headers=2,
        notes=[
            "Over assets, [95 % bootstrap over their families]. Coverage: of the panel's width and height, the "
            "handle's length and its height on the front, the share that lies between the least and the greatest in "
            "the training set, with the factors by which demonstrations stretch it."
        ],
    )


def _remark(row: dict[str, float]) -> str:
    return f"[{format_signed(row['low'])} to {format_signed(row['high'])}] {count(int(row['assets']), 'asset')}"
