"""`choice.png`: models over width of the front and height of the handle, those that were chosen marked."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from plugins.pictures.roles import representatives
from plugins.studies.choice import Choice
from plugins.studies.choice_report import share
from plugins.studies.coverage import HEIGHT, WIDTH
from stages.contracts import write_atomically
from stages.contracts.policies import TaskAsset

WIDTHS = (10, 15, 20, 30, 40, 60, 80, 120, 160)  # cm, on the axis
MARKED, REST, LONELY = "#0072B2", "#9a9c9e", "#D55E00"


def write_picture(path: Path, choice: Choice, pool: Sequence[TaskAsset], snapshots: tuple[Path, ...]) -> None:
    """Draw the models of the pool; below, those chosen as the shards show them, if there are any."""
    views = representatives({model.asset for model in choice.models}, snapshots)
    columns = max(4, -(-len(choice.models) // 2))
    rows = -(-len(choice.models) // columns) if views else 0
    figure = plt.figure(figsize=(8, 4.6 + 2 * rows), layout="constrained")
    grid = figure.add_gridspec(1 + rows, columns, height_ratios=[4.6, *[2.0] * rows])
    draw_models(figure.add_subplot(grid[0, :]), choice, pool)
    for number, model in enumerate(choice.models if views else ()):
        axes = figure.add_subplot(grid[1 + number // columns, number % columns])
        axes.set_axis_off()
        axes.set_title(f"{number + 1}  {model.asset}", fontsize=8)
        if model.asset in views:
            axes.imshow(views[model.asset])
    with write_atomically(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110, metadata={"Software": None})
    plt.close(figure)


def draw_models(axes: Axes, choice: Choice, pool: Sequence[TaskAsset]) -> None:
    """A point per model, a number and the ellipse of distance 1 per model that was chosen."""
    turn = np.linspace(0, 2 * np.pi, 73)
    for number, model in enumerate(choice.models, start=1):
        wide, high = 100 * model.panel_size[0], 100 * model.handle_height
        around = wide * np.exp(WIDTH * np.cos(turn)), high + 100 * HEIGHT * np.sin(turn)
        axes.fill(*around, color=MARKED, alpha=0.09, linewidth=0)
        axes.annotate(
            str(number), (wide, high), color="white", fontsize=8, ha="center", va="center", zorder=4,
            bbox={"boxstyle": "circle,pad=0.25", "color": MARKED},
        )  # fmt: skip
    for colour, label, some in (
        (REST, "models of the library", [model for model in pool if model.asset not in choice.alone]),
        (LONELY, "alone: none of another family within 1", [model for model in pool if model.asset in choice.alone]),
    ):
        places = np.array([(100 * model.panel_size[0], 100 * model.handle_height) for model in some]).reshape(-1, 2)
        axes.scatter(
            places[:, 0],
            places[:, 1],
            s=14,
            color=colour,
            alpha=0.8,
            linewidth=0,
            label=label if some else None,
            zorder=3,
        )
    axes.fill([], [], color=MARKED, alpha=0.25, label="chosen, and what lies within distance 1")
    axes.set_xscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticks(WIDTHS, map(str, WIDTHS))
    widths = [100 * model.panel_size[0] for model in pool]
    axes.set_xlim(min(widths) / 1.2, max(widths) * 1.2)
    axes.set_xlabel("width of the front, cm")
    axes.set_ylabel("height of the handle on the front, %")
    axes.set_ylim(-12, 112)
    axes.set_title(
        f"{choice.task}: {len(choice.models)} of {choice.usable} models by {choice.rule}; "
        f"{share(choice.within_1)} within distance 1, {share(choice.within_2)} within 2",
        fontsize=10,
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3, fontsize=8, frameon=False)
