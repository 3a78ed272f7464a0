"""What the figures share: colours, a look, and files that are the same bytes every time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.contracts.files import atomic
from stages.tables.order import title

# Okabe and Ito's palette: told apart by colour-blind readers as well
COLOURS = {"twin": "#D55E00", "cousins_2": "#56B4E9", "cousins_4": "#0072B2", "cousins_8": "#009E73", "all": "#CC79A7"}
MARKERS = {"twin": "s", "cousins_2": "v", "cousins_4": "o", "cousins_8": "^", "all": "D"}
GREY = "#8a8a86"
LOOK: dict[Any, Any] = {
    "svg.hashsalt": "acdc",  # ids inside an SVG are random without it
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#55554f",
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.grid": True,
    "grid.color": "#e7e5df",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.dpi": 160,
}


@contextmanager
def look() -> Iterator[None]:
    """The style of every figure."""
    with plt.rc_context(LOOK):
        yield


def colour(training_set: str) -> str:
    """Colour of a training set; grey for one the paper does not have."""
    return COLOURS.get(training_set, "#444444")


def rate_axis(axes: Axes, label: bool) -> None:
    """Success rates in percent, from 0 to 100, with room for markers."""
    axes.set_ylim(-4, 104)
    axes.set_yticks(range(0, 101, 25))
    if label:
        axes.set_ylabel("success (%)")


def not_run(axes: Axes, what: str = "not run", height: float = 0.5) -> None:
    """Say in a panel, at a fraction of its height, that there is nothing to show."""
    axes.text(
        0.5, height, what, transform=axes.transAxes, ha="center", va="center", color=GREY, style="italic", size=10
    )


def legend_name(training_set: str) -> str:
    """Name of a training set in a legend."""
    return f"trained on {title(training_set)}"


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write the figure as `name`.svg and `name`.png, without a date or a version in them."""
    for suffix, metadata in (("svg", {"Date": None, "Creator": None}), ("png", {"Software": None})):
        with atomic(folder / f"{name}.{suffix}") as path:
            figure.savefig(path, format=suffix, metadata=metadata)
    plt.close(figure)
