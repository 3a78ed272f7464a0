"""What the figures share: colours, a look, and files that are the same bytes every time."""

from collections.abc import Iterator, Sequence
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
COLOURS = {
    "twin": "#D55E00",
    "twin_randomised": "#E69F00",
    "cousins_2": "#56B4E9",
    "cousins_4": "#0072B2",
    "cousins_8": "#009E73",
    "all": "#CC79A7",
}
MARKERS = {"twin": "s", "twin_randomised": "P", "cousins_2": "v", "cousins_4": "o", "cousins_8": "^", "all": "D"}
INK, GREY, RULE, PAPER = "#22252a", "#6a6d70", "#e4e1d9", "#ffffff"
LOOK: dict[Any, Any] = {
    "svg.hashsalt": "acdc",  # ids inside an SVG are random without it
    "svg.fonttype": "none",  # text stays text: it can be searched, and takes the page's colours
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.grid": True,
    "grid.color": RULE,
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "figure.facecolor": PAPER,
    "axes.facecolor": PAPER,
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


def spread_out(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Places in order, moved as little as it takes to keep `gap` between neighbours and to stay in [low, high]."""
    if not places:
        return []
    gap = min(gap, (high - low) / max(len(places) - 1, 1))
    order = sorted(range(len(places)), key=places.__getitem__)
    moved = [places[i] for i in order]
    for index in range(1, len(moved)):
        moved[index] = max(moved[index], moved[index - 1] + gap)
    moved[-1] = min(moved[-1], high)
    for index in range(len(moved) - 2, -1, -1):
        moved[index] = min(moved[index], moved[index + 1] - gap)
    shift = max(0.0, low - moved[0])
    found = [0.0] * len(places)
    for place, index in zip(moved, order, strict=True):
        found[index] = place + shift
    return found


def legend_name(training_set: str) -> str:
    """Name of a training set in a legend."""
    return f"trained on {title(training_set)}"


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write the figure as `name`.svg and `name`.png, without a date or a version in them."""
    for suffix, metadata in (("svg", {"Date": None, "Creator": None}), ("png", {"Software": None})):
        with atomic(folder / f"{name}.{suffix}") as path:
            figure.savefig(path, format=suffix, metadata=metadata)
    plt.close(figure)
