"""Figures 4 and 9: success on test assets that are ever less like the twin."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.tables import asset_panels
from stages.tables.drawing import GREY, MARKERS, RULE, colour, legend_name, not_run, rate_axis, spread_out
from stages.tables.order import set_key, task_key, title
from stages.tables.table3 import TRAINED


def _tasks(pooled: pd.DataFrame, published: pd.DataFrame) -> list[str]:
    """The tasks that were run; if none was, the paper's."""
    return sorted({*pooled["task"]} or {*published["task"]}, key=task_key)


def _sets(pooled: pd.DataFrame, published: pd.DataFrame) -> list[str]:
    return sorted({*pooled["training_set"], *published["training_set"]}, key=set_key)


def _bars(cells: pd.DataFrame, low: Any, high: Any) -> Any:
    """Error bars in percent; never negative, as rounding may make them."""
    rate = cells["mean"].to_numpy()
    return 100 * np.clip(np.stack([rate - np.asarray(low), np.asarray(high) - rate]), 0, None)


def tested(pooled: pd.DataFrame) -> pd.DataFrame:
    """The cells of the paper's figures: those on test assets, not on the assets that a policy was trained on."""
    return pooled[pooled["test_asset"] != TRAINED]


def figure4(
    cells: pd.DataFrame, published: pd.DataFrame, over: tuple[pd.DataFrame, pd.DataFrame] | None = None
) -> Figure:
    """Success against what tells a test asset from the twin: a column per task that was run, a colour per set.

    Above, of `over` (as `asset_panels.points` and `.thirds` give): success on unseen assets against distance and
    against the length of the handle. Below, on the roles of Table 3, with our intervals; then the paper's figure, its
    bars the standard deviation over runs; its distances are under another encoder.
    """
    cells = tested(cells)
    tasks = _tasks(cells if over is None else pd.concat([cells, over[0]]), published)
    first = 0 if over is None else len(asset_panels.AXES)
    rows = first + (2 if len(cells) and published["task"].isin(tasks).any() else 1)
    width = max(4.6, 3.4 * len(tasks))
    figure, axes = plt.subplots(rows, len(tasks), figsize=(width, 3.2 * rows), squeeze=False, layout="constrained")
    for column, task in enumerate(tasks):
        if over is not None:
            points, thirds = (part[part["task"] == task] for part in over)
            asset_panels.draw(axes[:first, column], points, thirds, column == 0)
        ours = cells[cells["task"] == task].sort_values("dino_distance")
        _distances(axes[first, column], ours, column == 0, f"{title(task)}{', roles' if first else ''}")
        if rows == first + 2:
            theirs = published[published["task"] == task].sort_values("dino_distance")
            ends = [(theirs["mean"] + sign * theirs["std"]).clip(0, 1) for sign in (-1, 1)]
            theirs = theirs.assign(low=ends[0], high=ends[1])
            _distances(axes[first + 1, column], theirs, column == 0, f"{title(task)}, paper")
    handles, labels = _legend(axes.ravel())
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=int(width / 2.2))
    return figure


def _distances(panel: Axes, cells: pd.DataFrame, first: bool, name: str) -> None:
    """One panel of Figure 4."""
    rate_axis(panel, first)
    panel.set_title(name, loc="left", pad=38 if len(cells) else None)
    panel.set_xlabel("distance of the test asset from the twin")
    panel.grid(False, axis="x")
    if cells.empty:
        not_run(panel, "not run" if "paper" not in name else "not in the paper")
        panel.set_xticks([])
        return
    sets = sorted(cells["training_set"].unique(), key=set_key)
    extent = cells["dino_distance"].max() - cells["dino_distance"].min() or 1.0
    panel.set_xlim(cells["dino_distance"].min() - 0.06 * extent, cells["dino_distance"].max() + 0.06 * extent)
    for index, training_set in enumerate(sets):
        line = cells[cells["training_set"] == training_set]
        shift = 0.015 * extent * (index - (len(sets) - 1) / 2)  # keeps the bars of different sets apart
        panel.errorbar(
            line["dino_distance"] + shift, 100 * line["mean"], yerr=_bars(line, line["low"], line["high"]),
            color=colour(training_set), marker=MARKERS.get(training_set, "x"), markersize=5, linewidth=1.8,
            elinewidth=1, capsize=2.5, label=legend_name(training_set),
        )  # fmt: skip
    _mark_assets(panel, cells)


def _mark_assets(panel: Axes, cells: pd.DataFrame) -> None:
    """Names of the test assets above the panel, clear of all lines and of each other, led to their distances."""
    assets = cells.drop_duplicates("test_asset")
    distances = assets["dino_distance"].tolist()
    low, high = panel.get_xlim()
    places = spread_out(distances, 0.075 * (high - low), low, high)
    for name, distance, place in zip(assets["test_asset"], distances, places, strict=True):
        panel.axvline(distance, color=RULE, linewidth=0.7, zorder=0)
        panel.annotate(
            title(name), (distance, 1), xytext=(place, 1.05), xycoords=("data", "axes fraction"),
            textcoords=("data", "axes fraction"), rotation=40, size=7, color=GREY, va="bottom", ha="left",
            rotation_mode="anchor", annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def _legend(panels: Any) -> tuple[list[Any], list[str]]:
    found: dict[str, Any] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    return list(found.values()), list(found)


def figure9(pooled: pd.DataFrame, published: pd.DataFrame) -> Figure:
    """A panel per task that was run (rows) and training set (columns): ours, and the paper's as a faint dashed line.

    The four test assets stand from left to right, as in the paper: distances under different encoders do not compare.
    Our bars are the standard deviation over runs where there are two or more, else the Wilson interval of the run.
    """
    pooled = tested(pooled)
    tasks, sets = _tasks(pooled, published), _sets(pooled, published)
    roles = sorted({*pooled["test_asset"], *published["test_asset"]}, key=set_key)
    figure, axes = plt.subplots(
        len(tasks), len(sets), figsize=(2.1 * len(sets), 2.0 * len(tasks) + 0.5), squeeze=False, sharex=True,
        sharey=True, layout="constrained",
    )  # fmt: skip
    for row, task in enumerate(tasks):
        for column, name in enumerate(sets):
            panel = axes[row, column]
            rate_axis(panel, column == 0)
            panel.set_xticks(range(len(roles)), [title(role) for role in roles], size=6.5, rotation=30)
            panel.set_xlim(-0.4, len(roles) - 0.6)
            if row == 0:
                panel.set_title(title(name), color=colour(name))
            _panel(panel, name, roles, *(_cells(table, task, name) for table in (pooled, published)))
        axes[row, 0].set_ylabel(f"{title(task)}\nsuccess (%)")
    handles, labels = _legend(axes.ravel())
    figure.legend(handles, labels, loc="outside lower center", ncols=6)
    return figure


def _cells(table: pd.DataFrame, task: str, training_set: str) -> pd.DataFrame:
    return table[(table["task"] == task) & (table["training_set"] == training_set)]


def _panel(panel: Axes, name: str, roles: list[str], ours: pd.DataFrame, theirs: pd.DataFrame) -> None:
    if len(theirs):
        theirs = theirs.sort_values("test_asset", key=lambda column: column.map(roles.index))
        places = theirs["test_asset"].map(roles.index)
        panel.plot(places, 100 * theirs["mean"], "--", color=GREY, linewidth=1, alpha=0.8, label="paper, mean ± std")
        low, high = (np.clip(100 * (theirs["mean"] + sign * theirs["std"]), 0, 100) for sign in (-1, 1))
        panel.fill_between(places, low, high, color=GREY, alpha=0.12, linewidth=0)
    if ours.empty:
        height = 0.5 if theirs.empty else 0.13 if theirs["mean"].mean() > 0.35 else 0.8  # clear of the paper's line
        not_run(panel, "not run" if len(theirs) else "not run,\nnor in the paper", height)
        return
    ours = ours.sort_values("test_asset", key=lambda column: column.map(roles.index))
    several = (ours["runs"] > 1).to_numpy()
    low = np.where(several, np.clip(ours["mean"] - ours["std"], 0, 1), ours["low"])
    high = np.where(several, np.clip(ours["mean"] + ours["std"], 0, 1), ours["high"])
    panel.errorbar(
        ours["test_asset"].map(roles.index), 100 * ours["mean"], yerr=_bars(ours, low, high), color=colour(name),
        marker="o", markersize=4.5, linewidth=1.8, elinewidth=1, capsize=2.5, label=f"ours, {title(name)}",
    )  # fmt: skip
