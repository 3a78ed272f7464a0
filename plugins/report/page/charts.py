"""Charts by matplotlib, as SVG."""

import base64
import io
import math

import pandas as pd
from markupsafe import Markup
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from roomkin.stages.tables.figures import GREY, color, marker, style
from roomkin.stages.tables.order import SKILL, set_key, title

Points = list[tuple[float, float]]

SERIES = ("all", "cousins_8", "cousins_4", "twin")  # colors of lines that are not training sets


def embed_svg(svg: bytes, alt: str) -> Markup:
    """An SVG file as a picture of the page."""
    source = base64.b64encode(svg).decode("ascii")
    return Markup('<img class="chart" src="data:image/svg+xml;base64,{}" alt="{}">').format(source, alt)


def _draw_figure(figure: Figure, alt: str) -> Markup:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    return embed_svg(buffer.getvalue(), alt)


def line_chart(series: dict[str, Points], x_label: str, alt: str) -> Markup:
    """A small line chart with a legend.

    Args:
        series: name -> (x, y) points; points that are not finite are left out.
        alt: what the chart shows, for screen readers.
    """
    lines = {name: [p for p in points if all(map(math.isfinite, p))] for name, points in series.items()}
    if not any(lines.values()):
        return Markup("")
    with style():
        figure, axes = plt.subplots(figsize=(3.6, 2.3), layout="constrained")
        for (name, points), key in zip(lines.items(), SERIES * len(lines), strict=False):
            line = "o" if len(points) == 1 else "-"
            axes.plot(*zip(*points, strict=True), line, color=color(key), linewidth=1.6, label=name.replace("_", " "))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.yaxis.set_major_locator(MaxNLocator(5))
        axes.set_xlabel(x_label)
        figure.legend(loc="outside upper left", ncols=3)
        return _draw_figure(figure, alt)


def success_chart(cells: pd.DataFrame, alt: str, rows: dict[str, str], by: str, skill: float | None = None) -> Markup:
    """Success (`cells` as `cells.rates` gives) with intervals: lines of the column `by`, training sets as colors.

    Counts stand at the right, so that the chart can be read without the table.

    Args:
        rows: value of the column `by` -> what it is called, from top to bottom.
        skill: success of the scripted skill, drawn as a line across.
    """
    sets, names = sorted(cells["training_set"].unique(), key=set_key), list(rows)
    with style():
        figure, axes = plt.subplots(figsize=(4.4, 0.75 + 0.2 * len(rows) * (len(sets) + 0.9)), layout="constrained")
        step = 0.62 / max(len(sets), 1)
        for index, name in enumerate(sets):
            mine = cells[cells["training_set"] == name]
            places = mine[by].map(names.index) + step * (index - (len(sets) - 1) / 2)
            bars = [100 * (mine["mean"] - mine["low"]).clip(0), 100 * (mine["high"] - mine["mean"]).clip(0)]
            axes.errorbar(
                100 * mine["mean"], places, xerr=bars, fmt=marker(name), color=color(name), markersize=5.5,
                elinewidth=2, capsize=0, clip_on=False, label=f"trained on {title(name)}",
            )  # fmt: skip
            for place, successes, episodes in zip(places, mine["successes"], mine["episodes"], strict=True):
                axes.text(106, place, f"{successes}/{episodes}", va="center", size=7.5, color=color(name))
        if skill is not None:
            axes.axvline(100 * skill, color=GREY, linestyle="--", linewidth=1, clip_on=False, label=title(SKILL))
        axes.set_yticks(range(len(rows)), list(rows.values()))
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(0, 100)
        axes.xaxis.set_major_formatter(PercentFormatter(decimals=0))
        axes.grid(False, axis="y")
        axes.tick_params(axis="y", length=0)
        figure.legend(loc="outside upper left", ncols=2)
        return _draw_figure(figure, alt)
