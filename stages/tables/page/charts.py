"""Line charts as inline SVG that take their colours from the page, so that they follow its dark mode."""

import math

from markupsafe import Markup, escape
from matplotlib.ticker import MaxNLocator

WIDTH, HEIGHT = 340, 190
LEFT, RIGHT, TOP, BOTTOM = 44, 10, 10, 34
Points = list[tuple[float, float]]


def _ticks(low: float, high: float, count: int) -> list[float]:
    if high <= low:
        low, high = low - 0.5, high + 0.5
    return [float(tick) for tick in MaxNLocator(count).tick_values(low, high)]


def line_chart(series: dict[str, Points], x_label: str, label: str) -> Markup:
    """A small line chart with a legend.

    Args:
        series: name -> (x, y) points; points that are not finite are left out.
        label: what the chart shows, for screen readers.
    """
    lines = {name: [p for p in points if all(map(math.isfinite, p))] for name, points in series.items()}
    every = [point for points in lines.values() for point in points]
    if not every:
        return Markup("")
    xs, ys = ([point[axis] for point in every] for axis in (0, 1))
    x_ticks, y_ticks = _ticks(min(xs), max(xs), 4), _ticks(min(ys), max(ys), 4)
    x_low, x_high = min(xs), max(max(xs), min(xs) + 1e-9)
    y_low, y_high = y_ticks[0], y_ticks[-1]

    def place(x: float, y: float) -> tuple[float, float]:
        across = (x - x_low) / (x_high - x_low)
        up = (y - y_low) / (y_high - y_low)
        return LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)

    parts = [f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(label)}">']
    for tick in y_ticks:
        y = place(x_low, tick)[1]
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y + 3:.1f}" text-anchor="end">{tick:g}</text>')
    for tick in (tick for tick in x_ticks if x_low <= tick <= x_high):
        x = place(tick, y_low)[0]
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 13}" text-anchor="middle">{tick:g}</text>')
    parts.append(f'<text x="{WIDTH - RIGHT}" y="{HEIGHT - 6}" text-anchor="end">{escape(x_label)}</text>')
    for index, (name, points) in enumerate(lines.items()):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (place(*point) for point in points))
        parts.append(f'<polyline class="line line-{index % 4}" points="{path}"/>')
        x = LEFT + 90 * index
        y = HEIGHT - 9
        parts.append(f'<line class="line line-{index % 4}" x1="{x}" x2="{x + 14}" y1="{y}" y2="{y}"/>')
        parts.append(f'<text x="{x + 18}" y="{y + 3}">{escape(name)}</text>')
    return Markup("".join(parts) + "</svg>")
