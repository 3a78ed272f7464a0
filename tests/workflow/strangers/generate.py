"""A generation that puts every cousin into its object's box, which shares nothing with ours: `python -I -S`."""

import argparse
import json
from pathlib import Path

parser = argparse.ArgumentParser()
for flag in ("--cousins", "--objects", "--library", "--variant", "--options", "--out"):
    parser.add_argument(flag, required=True)
given = parser.parse_args()
seen, matched = (json.loads(Path(path).read_text()) for path in (given.objects, given.cousins))
cousins = {item["id"]: item.get("cousins", []) for item in matched["objects"]}
for rank in range(1, json.loads(given.options)["ranks"] + 1):
    placed = []
    for item in seen["objects"]:
        found, place = cousins.get(item["id"], [])[:rank], {"id": item["id"], "label": item["label"]}
        if item.get("status", "ok") != "ok" or not found:
            placed.append({**place, "status": "failed", "reason": item.get("reason") or "no cousin"})
            continue
        (x, y, z), size = item["box"]["center"], item["box"]["size"]
        placed.append({**place, "asset": found[-1]["asset"], "category": found[-1]["category"], "position": [x, y, z],
                       "yaw": item["box"]["yaw"], "size": size, "support": "floor",
                       "mounting": item["mounting"]})  # fmt: skip
    camera = {key: seen[key] for key in ("scene", "width", "height", "intrinsics", "floor_from_camera", "walls")}
    scene = {"version": 1, **camera, "variant": given.variant, "rank": rank, "objects": placed}
    (Path(given.out) / f"scene_{rank}.json").write_text(json.dumps(scene))
