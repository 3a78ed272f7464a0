"""A page of a submission: every room's picture with the boxes of the truth and of the submission, and its plan."""

import base64
import html
import io
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from roomkin.plugins.scorecard.placing import place_room
from roomkin.plugins.scorecard.truth import PictureTruth, Submission, read_truth
from roomkin.stages.contracts.files import write_text
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.geometry.boxes import FACES, UprightBox, corners
from roomkin.stages.geometry.frames import invert_transform, transform_points

WIDTH, HEIGHT = 640, 480  # pixels of a picture of the data set
TRUE, OURS, OTHER = (30, 160, 60), (225, 90, 0), (150, 150, 150)  # colors: truth, what stands for it, extra things
NEAREST = 0.05  # metres before the camera
STYLE = """body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:1320px;padding:0 1em;color:#222}
table{border-collapse:collapse;font-size:13px;display:block;overflow-x:auto}
td,th{border:1px solid #ccc;padding:3px 7px;text-align:left}
img{max-width:100%}h2{margin-top:2em}.true{color:#1ea03c}.ours{color:#e15a00}.extra{color:#888}"""


def write_page(
    out: Path, read: Submission, folders: Sequence[Path], things: pd.DataFrame, rooms: pd.DataFrame, parts: list[str]
) -> None:
    """Write index.html: it holds its pictures, and names no file.

    Args:
        out: its folder.
        read: the submission.
        folders: of the rooms.
        things: a row per thing.
        rooms: a row per room.
        parts: tables in Markdown.
    """
    about = read.about
    said = {"Code": about.code, "By": about.by, "Seen of these rooms": about.seen, "Note": about.note}
    lines = [f"<p><b>{name}:</b> {html.escape(text)}</p>" for name, text in said.items() if text]
    legend = '<p><b class="true">the truth</b>, <b class="ours">what stands for it</b>, '
    legend += '<b class="extra">other things</b>; in the plan a line goes to the front. The camera is the cross.</p>'
    body = [f"<h1>{html.escape(about.method)}</h1>", *lines, *(_to_html(part) for part in parts), legend]
    for folder in folders:
        row = rooms[rooms["picture"] == folder.name].iloc[0]
        told = f"{row['placed']} of {row['asked']} things are placed, {row['extra']} others"
        told += f"; not read: {row['unread']}" if row["unread"] else ""
        picture = base64.b64encode(draw_room(folder, read)).decode()
        body.append(f"<h2>{html.escape(folder.name)}</h2><p>{html.escape(told)}.</p>")
        body.append(f'<img alt="{html.escape(folder.name)}" src="data:image/webp;base64,{picture}">')
        body.append(_list_wrong(things[things["picture"] == folder.name]))
    head = f'<meta charset="utf-8"><title>{html.escape(about.method)}</title><style>{STYLE}</style>'
    whole = f"<!DOCTYPE html><html lang=en><head>{head}</head><body>{''.join(body)}</body></html>"
    write_text(out / "index.html", f"{whole}\n")


def draw_room(folder: Path, read: Submission) -> bytes:
    """The picture with the submission's boxes, and the plan with both, as WebP."""
    truth = read_truth(folder / "truth.json")
    asked = truth.list_asked("drawn masks" in read.about.given)
    scene = read.rooms.get(truth.name)
    placed = place_room(scene.room, truth, asked) if scene else None
    boxes = placed.boxes if placed else []
    paired = set(placed.pairs.values()) if placed else set()
    colored = [(box, OURS if place in paired else OTHER) for place, box in enumerate(boxes)]
    true = [(thing.box, TRUE) for thing in asked]
    rgb = Image.fromarray(read_rgb(folder / "rgb.png"))
    shown = rgb.copy()
    for box, color in [*true, *colored]:
        _draw_box(ImageDraw.Draw(shown), box, truth, rgb.size, color)
    plan = _draw_plan([*true, *colored], truth, rgb.height)
    whole = Image.new("RGB", (2 * rgb.width + plan.width, rgb.height), "white")
    for image, left in ((rgb, 0), (shown, rgb.width), (plan, 2 * rgb.width)):
        whole.paste(image, (left, 0))
    file = io.BytesIO()
    whole.save(file, "WEBP", quality=60, method=4)
    return file.getvalue()


def _draw_box(
    draw: ImageDraw.ImageDraw, box: UprightBox, truth: PictureTruth, size: tuple[int, int], color: tuple[int, int, int]
) -> None:
    """The edges of a box, as the camera sees them; what is behind it is left out."""
    points = transform_points(invert_transform(truth.pose), corners(box))
    middle = np.array([(size[0] - 1) / 2, (size[1] - 1) / 2])
    for face in FACES[4:]:
        _draw_edges(draw, points[[*face, face[0]]], truth.focal, middle, color)
    for below, above in zip(range(4), range(4, 8), strict=True):
        _draw_edges(draw, points[[below, above]], truth.focal, middle, color)


def _draw_edges(
    draw: ImageDraw.ImageDraw, points: NDArray[np.float64], focal: float, middle: NDArray[np.float64],
    color: tuple[int, int, int],
) -> None:  # fmt: skip
    for one, other in pairwise(points):
        if min(one[2], other[2]) > NEAREST:
            ends = [tuple((focal * point[:2] / point[2] + middle).tolist()) for point in (one, other)]
            draw.line(ends, fill=color, width=2)


def _draw_plan(
    boxes: Sequence[tuple[UprightBox, tuple[int, int, int]]], truth: PictureTruth, height: int
) -> Image.Image:
    """The room from above, y upwards."""
    scale = (height - 40) / max(truth.size)
    image = Image.new("RGB", (height, height), "white")
    draw = ImageDraw.Draw(image)

    def at(point: NDArray[np.float64]) -> tuple[float, float]:
        return float(20 + scale * point[0]), float(height - 20 - scale * point[1])

    x, y = truth.size
    draw.polygon([at(np.array(corner)) for corner in ((0, 0), (x, 0), (x, y), (0, y))], outline=(60, 60, 60))
    for box, color in boxes:
        plan = corners(box)[:4, :2]
        draw.polygon([at(point) for point in plan], outline=color, width=2)
        draw.line([at(box.center[:2]), at((plan[1] + plan[2]) / 2)], fill=color)
    eye = truth.pose[:2, 3]
    for step in ((0.1, 0.1), (0.1, -0.1)):
        draw.line([at(eye - step), at(eye + step)], fill=(0, 0, 0), width=2)
    return image


def _list_wrong(things: pd.DataFrame) -> str:
    """What is missing, and what has another name."""
    missed = things.loc[things["status"] != "ok", "label"]
    other = things[(things["status"] == "ok") & ~things["sensible"]]
    named = [f"{row['label']} is a {row['name']}" for _, row in other.iterrows()]
    lines = [
        f"Missed: {', '.join(missed)}." if len(missed) else "",
        f"Named else: {', '.join(named)}." if named else "",
    ]
    return f"<p>{html.escape(' '.join(filter(None, lines)))}</p>"


def _to_html(part: str) -> str:
    """A text with tables in Markdown."""
    rows, out = list[list[str]](), list[str]()
    for line in [*part.splitlines(), ""]:
        if line.startswith("|"):
            rows.append([html.escape(cell.strip()) for cell in line.strip("|").split(" | ")])
        else:
            out += [_make_table(rows)] if rows else []
            rows = []
            out += [f"<p>{html.escape(line)}</p>"] if line else []
    return "".join(out)


def _make_table(rows: list[list[str]]) -> str:
    head, _, *body = rows
    lines = [f"<tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in body]
    return f"<table>{''.join(lines)}</table>"
