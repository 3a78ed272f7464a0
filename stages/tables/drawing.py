"""What the figures share: colors, a style, and files that are the same bytes every time."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.policy_config import is_randomised, strip_randomised
from roomkin.stages.tables.order import title
from roomkin.stages.tables.text import NOT_RUN

# Okabe and Ito's palette, its sky blue darker, and a brown: color-blind readers can distinguish them
COLORS = {
    "twin": "#D55E00",
    "twin_randomised": "#E69F00",
    "cousins_2": "#3498DB",
    "cousins_4": "#0072B2",
    "cousins_8": "#009E73",
    "cover_8": "#8C510A",
    "all": "#CC79A7",
}
MARKERS = {"twin": "s", "cousins_2": "v", "cousins_4": "o", "cousins_8": "^", "cover_8": "*", "all": "D"}
GREY = "#6a6d70"  # as in figures.mplstyle


def style() -> AbstractContextManager[None]:
    """The style of every figure, without the user's own settings."""
    return plt.style.context("roomkin.stages.tables.figures", after_reset=True)


def color(training_set: str) -> str:
    """Color of a training set, randomised or not; grey for others, as sets by chance."""
    return COLORS.get(training_set, COLORS.get(strip_randomised(training_set), "#444444"))


def marker(training_set: str) -> str:
    """Marker of a training set: a plus for those that are randomised."""
    return "P" if is_randomised(training_set) else MARKERS.get(training_set, "x")


def rate_axis(axes: Axes, label: bool) -> None:
    """Success rates in percent, from 0 to 100, with room for markers."""
    axes.set_ylim(-4, 104)
    axes.set_yticks(range(0, 101, 25))
    if label:
        axes.set_ylabel("success (%)")


def mark_not_run(axes: Axes, what: str = NOT_RUN, height: float = 0.5) -> None:
    """Write in a panel, at a fraction of its height, that there is nothing to show."""
    axes.text(0.5, height, what, transform=axes.transAxes, ha="center", va="center", color=GREY, style="italic")


def draw_rates(axes: Axes, places: Any, rates: pd.DataFrame, training_set: str) -> None:
    """A line of success rates with their intervals (`mean`, `low`, `high`), in percent."""
    mean = rates["mean"].to_numpy()
    bars = 100 * np.clip([mean - rates["low"].to_numpy(), rates["high"].to_numpy() - mean], 0, None)
    axes.errorbar(
        places, 100 * mean, yerr=bars, color=color(training_set), marker=marker(training_set), markersize=5,
        linewidth=1.8, elinewidth=1, capsize=2.5, label=f"trained on {title(training_set)}",
    )  # fmt: skip


def save(figure: Figure, folder: Path, name: str, formats: tuple[str, ...] = ("svg", "png")) -> None:
    """Write the figure as `name`.<format>, without a date or a version in it; webp is small, for pages in git."""
    options: dict[str, dict[str, Any]] = {
        "svg": {"metadata": {"Date": None, "Creator": None}},
        "png": {"metadata": {"Software": None}},
        "webp": {"dpi": 96, "pil_kwargs": {"quality": 75, "method": 6}},
    }
    for suffix in formats:
        with write_atomically(folder / f"{name}.{suffix}") as path:
            figure.savefig(path, format=suffix, **options[suffix])
    plt.close(figure)
