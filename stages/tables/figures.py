"""The figures of the paper in one style, the same bytes every time: 6 of scenes, 4 and 9 of policies."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import pandas as pd
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.images import read_narrow
from roomkin.stages.contracts.policy_config import is_randomised, strip_randomised
from roomkin.stages.tables.rows import ROW, records, row_title, set_key, sort_key, title
from roomkin.stages.tables.table3 import TRAINED
from roomkin.stages.tables.text import NOT_RUN, distance_from_twin

matplotlib.use("Agg")


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


def figure6(pictures: dict[tuple[str, str], Path], rooms: list[str], width: int) -> Figure:
    """A grid of comparison pictures (input beside reconstruction): a row per room, a column per variant.

    Args:
        pictures: (room, variant) -> picture; the variant may be ''.
        rooms: rooms that get a row even if they were not run.
        width: of a picture, pixels at most.
    """
    names = sorted({*rooms, *(room for room, _ in pictures)}, key=sort_key)
    variants = sorted({variant for _, variant in pictures}) or [""]
    images = {key: np.asarray(read_narrow(path, width)) for key, path in pictures.items()}
    ratio = max((image.shape[0] / image.shape[1] for image in images.values()), default=0.4)
    missing = [name for name in names if not any((name, variant) in images for variant in variants)]
    heights = [0.05 if name in missing else ratio for name in names]
    inches = 6.0 if len(variants) == 1 else 4.2
    figure, axes = plt.subplots(
        len(names), len(variants), squeeze=False, layout=ConstrainedLayoutEngine(h_pad=0.02, hspace=0.01),
        figsize=(inches * len(variants) + 0.7, inches * sum(heights) + 0.09 * len(names) + 0.3),
        gridspec_kw={"height_ratios": heights},
    )  # fmt: skip
    for row, name in enumerate(names):
        for column, variant in enumerate(variants):
            panel = axes[row, column]
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
            if (name, variant) in images:
                panel.imshow(images[name, variant], interpolation="lanczos")
            else:
                panel.set_facecolor("#f3f1ea")
                mark_not_run(panel)
            if row == 0 and variant:
                panel.set_title(f"input and reconstruction, variant ({variant})")
        axes[row, 0].set_ylabel(title(name), rotation=0, ha="right", va="center")
    return figure


Row = dict[str, Any]  # target, task, policy


class Panels(NamedTuple):
    """Panels that Figure 4 has before its own: how many, their rows (`ROW`), and what draws those of one row."""

    columns: int
    rows: pd.DataFrame
    draw: Callable[[Sequence[Axes], Row], None]


def of_row(table: pd.DataFrame, row: Row, training_set: str | None = None) -> pd.DataFrame:
    """The rows of a table about one target and policy, and about one training set if it is named."""
    found = table[(table["target"] == row["target"]) & (table["policy"] == row["policy"])]
    return found if training_set is None else found[found["training_set"] == training_set]


def _rows(cells: pd.DataFrame, published: pd.DataFrame) -> list[Row]:
    """Targets and policies that were run; if none was, the paper's."""
    return records((cells if len(cells) else published)[ROW].drop_duplicates())


def _select_tested(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells of the paper's figures: those on test assets, not on the assets that a policy was trained on."""
    return cells[cells["test_asset"] != TRAINED]


def _with_deviation(cells: pd.DataFrame) -> pd.DataFrame:
    """Intervals of one standard deviation over runs."""
    low, high = ((cells["mean"] + sign * cells["std"]).clip(0, 1) for sign in (-1, 1))
    return cells.assign(low=low, high=high)


def _legend(figure: Figure, columns: int) -> None:
    """One legend for all panels, below them."""
    found: dict[str, Any] = {}
    for panel in figure.axes:
        found |= dict(zip(*panel.get_legend_handles_labels()[::-1], strict=True))
    if found:
        figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=columns)


def figure4(cells: pd.DataFrame, published: pd.DataFrame, more: Panels | None = None, encoder: str = "") -> Figure:
    """Success against what tells a test asset from the twin: a row per target and policy, a color per set.

    From the left: those of `more`; on the roles of Table 3, with our intervals; the paper's figure, its bars the
    standard deviation over runs. `encoder` is ours, by whose features distances are.
    """
    cells = _select_tested(cells)
    rows = _rows(cells if more is None else pd.concat([cells, more.rows]), published)
    first = 0 if more is None else more.columns
    columns = first + (2 if len(cells) and any(len(of_row(published, row)) for row in rows) else 1)
    width = max(4.6, 2.9 * columns)  # four panels are as wide as a page, so that their text is not shrunk
    size = (width, 3.0 * len(rows) + 0.3)
    figure, axes = plt.subplots(len(rows), columns, figsize=size, squeeze=False, layout="constrained")
    for panels, row in zip(axes, rows, strict=True):
        if more is not None:
            more.draw(panels[:first], row)
        name = f"{row_title(row)}{', roles' if first else ''}"
        _distances(panels[first], of_row(cells, row), name, encoder)
        if columns == first + 2:
            paper = _with_deviation(of_row(published, row))
            panels[-1].set_visible(len(paper) > 0)
            _distances(panels[-1], paper, "the same in the paper", "DINOv2")
        panels[0].set_ylabel("success (%)")
    _legend(figure, int(width / 2.2))
    return figure


def _distances(panel: Axes, cells: pd.DataFrame, name: str, encoder: str) -> None:
    """One panel of Figure 4."""
    rate_axis(panel, False)
    panel.set_title(name, loc="left")
    if cells.empty:
        mark_not_run(panel)
        panel.set_xticks([])
        return
    cells = cells.sort_values("feature_distance")
    sets = sorted(cells["training_set"].unique(), key=set_key)
    step = 0.015 * (cells["feature_distance"].max() - cells["feature_distance"].min() or 1.0)
    for index, training_set in enumerate(sets):
        line = cells[cells["training_set"] == training_set]
        shift = step * (index - (len(sets) - 1) / 2)  # keeps the bars of different sets apart
        draw_rates(panel, line["feature_distance"] + shift, line, training_set)
    names = ", ".join(title(asset) for asset in cells["test_asset"].unique())
    panel.set_xlabel(f"{distance_from_twin(encoder)}\n{fill(names, 40)}")


def figure9(cells: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """A panel per target and policy (rows) and training set of ours (columns); the paper's as a faint dashed line.

    The four test assets stand from left to right, as in the paper: distances under different encoders do not compare.
    Our bars are the standard deviation over runs where there are two or more, else the interval of the run.
    """
    cells = _select_tested(cells)
    rows = _rows(cells, published)
    sets = sorted({*(cells if len(cells) else published)["training_set"]}, key=set_key)
    test_assets = sorted({*cells["test_asset"], *published["test_asset"]}, key=set_key)
    figure, axes = plt.subplots(
        len(rows), len(sets), figsize=(max(4.6, 2.6 * len(sets)), 2.2 * len(rows) + 0.5), squeeze=False, sharex=True,
        sharey=True, layout="constrained",
    )  # fmt: skip
    for number, row in enumerate(rows):
        for column, name in enumerate(sets):
            panel = axes[number, column]
            rate_axis(panel, column == 0)
            panel.set_xticks(range(len(test_assets)), [title(name) for name in test_assets], size=8, rotation=30)
            panel.set_xlim(-0.4, len(test_assets) - 0.6)
            if number == 0:
                panel.set_title(title(name), color=color(name))
            _positions(panel, name, test_assets, of_row(cells, row, name), of_row(published, row, name))
        axes[number, 0].set_ylabel(f"{fill(row_title(row), 16)}\nsuccess (%)")
    _legend(figure, min(len(sets) + 1, 4))
    return figure


def _positions(panel: Axes, name: str, test_assets: list[str], ours: pd.DataFrame, theirs: pd.DataFrame) -> None:
    """One panel of Figure 9."""
    if len(theirs):
        theirs = _with_deviation(theirs.sort_values("test_asset", key=lambda column: column.map(test_assets.index)))
        places = theirs["test_asset"].map(test_assets.index)
        panel.plot(places, 100 * theirs["mean"], "--", color=GREY, linewidth=1, alpha=0.8, label="paper, mean ± std")
        panel.fill_between(places, 100 * theirs["low"], 100 * theirs["high"], color=GREY, alpha=0.12, linewidth=0)
    if ours.empty:
        height = 0.5 if theirs.empty else 0.13 if theirs["mean"].mean() > 0.35 else 0.8  # clear of the paper's line
        mark_not_run(panel, height=height)
        return
    ours = ours.sort_values("test_asset", key=lambda column: column.map(test_assets.index))
    deviation = _with_deviation(ours)
    bars = ours.assign(**{end: np.where(ours["runs"] > 1, deviation[end], ours[end]) for end in ("low", "high")})
    draw_rates(panel, ours["test_asset"].map(test_assets.index), bars, name)
