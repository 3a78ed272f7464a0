"""docs/results/gallery.md: the rooms of a set, told their outlines and names, and with no hand."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.open_rooms import pictures
from roomkin.plugins.pictures.look import draw_side_by_side, resize_to
from roomkin.plugins.pictures.scenes import run as draw_scenes
from roomkin.stages.contracts.images import read_rgb

HALF, WIDTH = "held_out", 427  # the set that is shown, pixels of a picture
PANELS = {"drawn": "told outlines and names", "unaided": "no hand"}
COUNTED = {"sensible": "category", "size": "size", "place": "place", "carrier": "carrier"}
WORST, FAR = 3, 15  # errors that are named, and from how many cm on: chosen
OFF = {"place": "from its place", "width": "in width", "depth": "in depth", "height": "in height"}


def gallery(root: Path, results: Path, out: Path) -> None:
    """Write gallery.md and ../images/gallery_*.webp beside the open.csv.xz in `out`; `root`: of `render` and `run`."""
    rows = pd.read_csv(out / "open.csv.xz", low_memory=False)
    rows = rows[(rows["half"] == HALF) & (rows["rank"] == 1) & (rows["judge"] == "geometry")]
    parts = []
    for folder in sorted(pictures.folders(root, HALF)):
        name = folder.name.split("_", 1)[1]
        with TemporaryDirectory(prefix="acdc-gallery-") as drawn:
            panels = [("input", resize_to(read_rgb(folder / "rgb.png"), WIDTH))]
            for masks, title in PANELS.items():
                panels += _draw(root / "results" / masks / folder.name, title, results, Path(drawn))
        path = out.parent / "images" / f"gallery_{name}.webp"
        draw_side_by_side(panels).save(path, quality=60, method=6)
        mine = rows[rows["picture"] == folder.name]
        kind, number = name.rsplit("_", 1)
        parts += [
            f"## {kind.capitalize()} {number}\n",
            f"![{kind.capitalize()} {number}: {', '.join(title for title, _ in panels)}](../images/{path.name})\n",
            *(f"{title.capitalize()}: {count(mine[mine['masks'] == masks])}\n" for masks, title in PANELS.items()),
            describe_worst(mine[mine["masks"] == "drawn"]) + "\n",
        ]
    intro = (Path(__file__).parent / "gallery.md").read_text(encoding="utf-8")
    commit = ", ".join(rows["version"].unique())
    (out / "gallery.md").write_text(intro.format(commit=commit, rooms="\n".join(parts)), encoding="utf-8")


def _draw(made: Path, title: str, results: Path, out: Path) -> list[tuple[str, NDArray[np.uint8]]]:
    scene = made / "geometry" / "scene_1.json"
    if not scene.is_file():
        return []
    draw_scenes(
        scenes=(scene,),
        objects=made / "extraction/objects.json",
        image=made / "input/rgb.png",
        library=results / "assets/library/library.json",
        out=out / made.parent.name,
        width=WIDTH,
    )
    return [(title, read_rgb(out / made.parent.name / "scene_1.png"))]


def count(rows: pd.DataFrame) -> str:
    """How many of a picture's things came out right."""
    right = (f"{name} {int(rows[column].eq(True).sum())}" for column, name in COUNTED.items())
    return f"**{len(rows)} things: placed {int((rows['status'] == 'ok').sum())}, {', '.join(right)}.**"


def describe_worst(rows: pd.DataFrame) -> str:
    """The things that are farthest from their truth, and those that became something else."""
    placed = rows[rows["status"] == "ok"]
    far = sorted(
        (
            (abs(off), f"{row.label} {abs(off):.0f} cm {words}")
            for row in placed.itertuples()
            for measure, words in OFF.items()
            if abs(off := getattr(row, f"off_{measure}_cm")) >= FAR
        ),
        reverse=True,
    )
    other = [f"{row.label} (a {row.category.replace('_', ' ')})" for row in placed.itertuples() if not row.sensible]
    lines = [f"Farthest off: {', '.join(text for _, text in far[:WORST])}."] if far else [f"Nothing is {FAR} cm off."]
    return " ".join([*lines, *([f"Became something else: {', '.join(other)}."] if other else [])])
