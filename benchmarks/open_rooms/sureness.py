"""How often sizes and places are right against how sure of them scenes are."""

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from roomkin.stages.tables.figures import save, style

COLORS = {"work": "#6a6d70", "held_out": "#0072B2", "third": "#D55E00", "fourth": "#009E73"}
BINS = np.linspace(0, 1, 6)
JUDGED = ["of the", "said, right (%)", "AUC", "Brier score, by the mean alone",
          "surer than half: right", "others: right", "surer than 90 %: right"]  # fmt: skip


def bin_sureness(rows: pd.DataFrame) -> pd.DataFrame:
    """By fifths of `sure_of_size`: its mean, the share of sizes that are right, the number of things."""
    known = rows.dropna(subset=["sure_of_size"])
    fifth = pd.cut(known["sure_of_size"], BINS, include_lowest=True)
    groups = known.groupby(fifth, observed=True)
    found = groups.agg(sure=("sure_of_size", "mean"), right=("size", "mean"), things=("size", "size"))
    return found.reset_index(drop=True).astype({"right": float})


def draw_sureness(rows: pd.DataFrame, path: Path) -> None:
    """A line per set of rooms; deviations are those of shares of so many things."""
    with style():
        figure, axes = plt.subplots(figsize=(4.6, 3.4), layout="constrained")
        axes.plot([0, 100], [0, 100], color="#22252a", linewidth=0.8, linestyle="--", label="as sure as right")
        for place, (half, color) in enumerate(COLORS.items()):
            found = bin_sureness(rows[rows["half"] == half])
            if found.empty:
                continue
            deviation = np.sqrt(np.maximum(found["right"] * (1 - found["right"]), 0.05) / found["things"])
            axes.errorbar(
                100 * found["sure"] + place - 1,  # side by side
                100 * found["right"], yerr=100 * deviation, color=color, marker="o",
                linewidth=1.8, elinewidth=1, capsize=2.5, label=f"{half.replace('_', ' ')} ({found['things'].sum()})",
            )  # fmt: skip
        axes.set_xlabel("sure of the size (%)")
        axes.set_ylabel("sizes right within 10 % or 3 cm (%)")
        axes.set_ylim(-4, 104)
        axes.legend(loc="upper left")
        save(figure, path.parent, path.stem, ("svg",))


def judge_sureness(rows: pd.DataFrame) -> Iterator[list[str]]:
    """A line a set and measure: chances that scenes give (drawn masks, `geometry`, rank 1) against what is right."""
    first = rows[(rows["rank"] == 1) & (rows["judge"] == "geometry") & (rows["masks"] == "drawn")]
    for half in COLORS:
        for measure in ("size", "place"):
            known = first[first["half"] == half].dropna(subset=[f"sure_of_{measure}"])
            if len(known):
                chances = _judge_chances(known[f"sure_of_{measure}"], known[measure].astype(float))
                yield [half.replace("_", " "), measure, *chances]


def _judge_chances(said: "pd.Series[float]", right: "pd.Series[float]") -> list[str]:
    ones = right.sum()
    zeros = len(right) - ones
    auc = (said.rank()[right == 1].sum() - ones * (ones + 1) / 2) / (ones * zeros) if ones * zeros else np.nan
    parts = (right[said > 0.5], right[said <= 0.5], right[said > 0.9])
    return [
        f"{100 * said.mean():.0f}, {100 * right.mean():.0f}",
        f"{auc:.2f}",
        f"{((said - right) ** 2).mean():.3f}, {right.var(ddof=0):.3f}",
        *(f"{part.sum():.0f} of {len(part)}" for part in parts),
    ]
