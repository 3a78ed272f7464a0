"""How often sizes are right against how sure of them scenes are."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from stages.tables.drawing import save, style

COLORS = {"work": "#6a6d70", "held_out": "#0072B2", "third": "#D55E00", "fourth": "#009E73"}
BINS = np.linspace(0, 1, 6)


def bin_sureness(rows: pd.DataFrame) -> pd.DataFrame:
    """By fifths of `sure_of_size`: its mean, the share of sizes that are right, the number of things."""
    known = rows.dropna(subset=["sure_of_size"])
    fifth = pd.cut(known["sure_of_size"], BINS, include_lowest=True)
    found = known.groupby(fifth, observed=True).agg(
        sure=("sure_of_size", "mean"), right=("size", "mean"), things=("size", "size")
    )
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
