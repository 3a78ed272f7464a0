"""Real rooms without a hand: what `eyes see` finds in frames whose things were outlined by hand, and how it is called.

python -m benchmarks.real_rooms DATA OUT

DATA: a folder per frame with color.png, depth.png, camera.json, masks.png and annotations.json (its labels). A thing is
found if an outline has an IoU of .5 with it; right is a name that the label means. `drawn`: names on the outlines that
were drawn. Placed things are right if they show a drawn thing, are called so, and their top is within 10 cm.
"""

import argparse
import json
from pathlib import Path

import cv2
import numpy as np

from benchmarks.open_rooms.tables import table
from plugins.eyes import see
from plugins.inputs import from_rgbd
from plugins.inputs.rgbd.frame import Frame
from plugins.names.observed import observe
from plugins.names.propose import propose_names
from stages.contracts import read_json
from stages.contracts.categories import category_in
from stages.contracts.scene_input import read_scene_input
from stages.contracts.things import THINGS, Things
from stages.geometry.cameras import back_project
from stages.geometry.frames import apply

FOUND, HEIGHT = 0.5, 0.1  # IoU; metres


def measure(frame: Path, out: Path) -> list[str]:
    """A row of the table."""
    from_rgbd.run(
        out=out / "view", rgb=frame / "color.png", depth=frame / "depth.png", camera=(str(frame / "camera.json"),)
    )
    see.run(picture=out / "view", out=out / "seen")
    given, things = read_scene_input(out / "seen"), read_json(Things, out / "seen" / THINGS)
    drawn = np.atleast_3d(cv2.imread(str(frame / "masks.png"), cv2.IMREAD_UNCHANGED))[..., 0]
    matrix = np.array(given.camera.intrinsics, dtype=float)
    view = see.look(Frame(given.rgb, given.depth, matrix))
    heights = apply(view.surfaces.frame, back_project(given.depth.astype(float), matrix))[..., 2]

    def find_top(mask: np.ndarray) -> float:
        known = mask & (given.depth > 0)
        return float(np.quantile(heights[known], 0.97)) if known.any() else np.nan

    counts = dict.fromkeys(("things", "found", "first", "three", "drawn first", "drawn three", "right"), 0)
    for item in json.loads((frame / "annotations.json").read_text())["objects"]:
        mask, meant = drawn == item["mask"], category_in(item["label"])
        overlaps = [
            ((given.masks == one.mask) & mask).sum() / ((given.masks == one.mask) | mask).sum() for one in things.things
        ]
        best = things.things[int(np.argmax(overlaps))]
        said = [
            one.name
            for one in propose_names(observe(view.rgb, view.depth, mask, matrix, view.surfaces.frame)).proposals
        ]
        counts["things"] += 1
        counts["drawn first"] += category_in(said[0]) == meant
        counts["drawn three"] += meant in map(category_in, said[:3])
        if max(overlaps) < FOUND:
            continue
        names = [category_in(one.name) for one in best.names]
        counts["found"] += 1
        counts["first"] += names[0] == meant
        counts["three"] += meant in names[:3]
        near = abs(find_top(given.masks == best.mask) - find_top(mask)) < HEIGHT
        counts["right"] += bool(near and names[0] == meant and not best.left_out)
    placed = sum(not one.left_out for one in things.things)
    ground = "-" if things.ground is None else f"{things.ground.camera_height:.2f}"
    return [frame.name, ground, str(things.walls), *map(str, counts.values()), str(placed)]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("out", type=Path)
    asked = parser.parse_args()
    frames = [path for path in sorted(asked.data.iterdir()) if (path / "annotations.json").is_file()]
    rows = [measure(frame, asked.out / frame.name) for frame in frames]
    head = [
        "frame",
        "camera, m",
        "walls",
        "things",
        "found",
        "first name",
        "one of three",
        "drawn: first",
        "one of three",
    ]
    print(table([*head, "placed and right", "placed"], iter(rows)))


if __name__ == "__main__":
    main()
