"""An extraction in plain Python, which shares nothing with ours: run it with `python -I -S`.

The floor is a least-squares plane, a box is the extent of a mask's points, everything stands on the floor.
"""

import argparse
import ast
import json
import math
import struct
import zipfile
import zlib
from array import array
from collections import Counter
from pathlib import Path

parser = argparse.ArgumentParser()
for flag in ("--input", "--scene", "--options", "--seed", "--out"):
    parser.add_argument(flag, required=True)
given = parser.parse_args()
folder, out = Path(given.input), Path(given.out)


def png16(path):
    """Rows of a 16-bit grey PNG."""
    raw, at, data, width, height = path.read_bytes(), 8, b"", 0, 0
    while at < len(raw):
        length, kind = struct.unpack(">I4s", raw[at : at + 8])
        body = raw[at + 8 : at + 8 + length]
        width, height = struct.unpack(">II", body[:8]) if kind == b"IHDR" else (width, height)
        data, at = data + (body if kind == b"IDAT" else b""), at + length + 12
    data, stride, above, rows = zlib.decompress(data), 2 * width, bytearray(2 * width), []
    for y in range(height):
        kind, line = data[y * (stride + 1)], bytearray(data[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for x in range(stride):
            a, b, c = line[x - 2] if x > 1 else 0, above[x], above[x - 2] if x > 1 else 0
            paeth = min((a, b, c), key=lambda v: abs(a + b - c - v))
            line[x] = (line[x] + (0, a, b, (a + b) // 2, paeth)[kind]) % 256
        rows.append(struct.unpack(f">{width}H", line))
        above = line
    return rows


def chunk(kind, body):
    """One part of a PNG."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def npy(values, shape):
    """The bytes of a float32 .npy file."""
    header = repr({"descr": "<f4", "fortran_order": False, "shape": shape}).encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + array("f", values).tobytes()


with zipfile.ZipFile(folder / "depth.npz") as file:
    raw = file.read("depth.npy")
start = 10 + struct.unpack("<H", raw[8:10])[0]
height, width = ast.literal_eval(raw[10:start].decode())["shape"]
depth, masks = array("f", raw[start:]), png16(folder / "masks.png")
known = json.loads((folder / "annotations.json").read_text())
camera = json.loads((folder / "camera.json").read_text())
(fx, _, cx), (_, fy, cy), _ = camera["intrinsics"]
points = {}
for v in range(0, height, 2):
    for u in range(0, width, 2):
        z = depth[v * width + u]
        if z > 0:
            points.setdefault(masks[v][u], []).append(((u - cx) * z / fx, (v - cy) * z / fy, z))

floor = points[known["floor"]]  # y = a x + b z + c, by Cramer's rule
sums = Counter()
for x, y, z in floor:
    sums.update({"xx": x * x, "xz": x * z, "zz": z * z, "x": x, "z": z, "xy": x * y, "zy": z * y, "y": y, "n": 1})
rows = [[sums["xx"], sums["xz"], sums["x"]], [sums["xz"], sums["zz"], sums["z"]], [sums["x"], sums["z"], sums["n"]]]
right = [sums["xy"], sums["zy"], sums["y"]]


def determinant(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


whole = determinant(rows)
a, b, c = (
    determinant([[*row[:k], value, *row[k + 1 :]] for row, value in zip(rows, right, strict=True)]) / whole
    for k in range(3)
)
norm = math.sqrt(a * a + 1 + b * b)
up = [a / norm, -1 / norm, b / norm]
ahead = [-up[2] * up[0], -up[2] * up[1], 1 - up[2] * up[2]]
ahead = [value / math.hypot(*ahead) for value in ahead]
left = [up[1] * ahead[2] - up[2] * ahead[1], up[2] * ahead[0] - up[0] * ahead[2], up[0] * ahead[1] - up[1] * ahead[0]]
pose = [[*ahead, 0.0], [*left, 0.0], [*up, c / norm], [0.0, 0.0, 0.0, 1.0]]

objects, clouds, numbers = [], {}, Counter()
for item in known["objects"]:
    name = item["label"].replace(" ", "_")
    numbers[name] += 1
    entry = {"id": f"{name}_{numbers[name]}", "label": item["label"], "mask": item["mask"]}
    entry |= {key: item[key] for key in ("articulated", "doors", "drawers")}
    cloud = [[sum(r * p for r, p in zip(row, (*q, 1.0), strict=True)) for row in pose[:3]]
             for q in points.get(item["mask"], [])]  # fmt: skip
    if len(cloud) < 20:
        objects.append({**entry, "status": "failed", "reason": "too few points"})
        continue
    spans = [sorted(p[k] for p in cloud) for k in range(3)]
    low, high = ([s[round(share * (len(s) - 1))] for s in spans] for share in (0.02, 0.98))
    low[2] = min(low[2], high[2] - 0.05)
    box = {"center": [(p + q) / 2 for p, q in zip(low, high, strict=True)],
           "size": [max(0.05, q - p) for p, q in zip(low, high, strict=True)], "yaw": 0.0}  # fmt: skip
    clouds[entry["id"]] = cloud
    objects.append({**entry, "points": len(cloud), "box": box, "mounting": {"type": 2, "walls": []}})
named = {item["mask"] for item in known["objects"]}
lines = (struct.pack(f">{width}H", *(value if value in named else 0 for value in row)) for row in masks)
pixels = zlib.compress(b"".join(b"\0" + line for line in lines))
out.with_name("masks.png").write_bytes(
    b"\x89PNG\r\n\x1a\n"
    + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
    + chunk(b"IDAT", pixels)
    + chunk(b"IEND", b"")
)
with zipfile.ZipFile(out.with_name("depth.npz"), "w") as file:
    file.writestr("depth.npy", raw)
with zipfile.ZipFile(out.with_name("clouds.npz"), "w") as file:
    for name, cloud in clouds.items():
        file.writestr(f"{name}.npy", npy([value for point in cloud for value in point], (len(cloud), 3)))
scene = {"version": 1, "scene": given.scene, "width": width, "height": height, "intrinsics": camera["intrinsics"],
         "floor_from_camera": pose, "walls": [], "objects": objects}  # fmt: skip
out.write_text(json.dumps(scene))
