"""A matching by words and counts, which shares nothing with ours: run it with `python -I -S`."""

import argparse
import json
from pathlib import Path

parser = argparse.ArgumentParser()
for flag in ("--objects", "--image", "--library", "--options", "--out"):
    parser.add_argument(flag, required=True)
parser.add_argument("--features", nargs="+")
parser.add_argument("--snapshots", nargs="+")
parser.add_argument("--without", nargs="*")
given = parser.parse_args()
gone = {name for path in given.without for name in json.loads(Path(path).read_text())["assets"]}
scene, library = (json.loads(Path(path).read_text()) for path in (given.objects, given.library))


def far(item, asset):
    said, named = set(item["label"].split()), set(asset["category"].split("_"))
    counts = abs(item["doors"] - asset["doors"]) + abs(item["drawers"] - asset["drawers"])
    return round(1 - len(said & named) / len(said | named) + counts / 10, 3)


entries = []
for item in scene["objects"]:
    if item.get("status", "ok") != "ok":
        entries.append({"id": item["id"], "label": item["label"], "status": "failed", "reason": item["reason"]})
        continue
    pool = [asset for asset in library["assets"] if (not item["doors"] or asset["doors"]) and asset["id"] not in gone]
    pool = sorted(pool, key=lambda asset: (far(item, asset), asset["id"]))[: json.loads(given.options)["k_cousins"]]
    view = {"yaw": 0.0, "distance": 0.0}
    cousins = [
        {"rank": rank, "asset": asset["id"], "category": asset["category"], "distance": far(item, asset), "votes": None,
         "orientation": view, "orientations": [view]}
        for rank, asset in enumerate(pool, 1)
    ]  # fmt: skip
    categories = [{"category": name, "distance": 0.0} for name in dict.fromkeys(asset["category"] for asset in pool)]
    entries.append({"id": item["id"], "label": item["label"], "categories": categories, "cousins": cousins})
Path(given.out).write_text(json.dumps({"version": 1, "scene": scene["scene"], "encoder": "words", "objects": entries}))
