"""Kettles, toasters, frying pans, jars."""

from typing import Any

import numpy as np

from stages.procedural.colours import APPLIANCE, GLAZES, METALS, PAINTS, WOODS, pick
from stages.procedural.model import METAL, PLASTIC, Draw, Model, Part, Size, moved, part
from stages.procedural.shapes import box, cushion, lathe, rod
from stages.procedural.vessels import ear, hollow

Rng = np.random.Generator
LIGHT = 300.0  # kg / m^3: a shell with machinery in it
DARK = (0.04, 0.04, 0.05)


def kettle(size: Size, p: dict[str, Any]) -> Model:
    """A kettle, its spout towards +x. Parameters: taper (top / foot), style (jug: a handle behind; stove: one above),
    knob, colours."""
    z = size[2]
    body = z * (0.93 if p["style"] == "jug" else 0.62)
    radius = min(0.39 * size[0], 0.5 * size[1])
    top = radius * float(p["taper"])
    shape = [(0, 0), (radius, 0), (radius, 0.12 * body), (top, 0.9 * body), (0.5 * top, body), (0, body)]
    if p["style"] == "stove":
        bulge = [(radius * (0.8 + 0.2 * np.sin(a)), body * (0.45 - 0.45 * np.cos(a))) for a in np.linspace(0, 2.6, 8)]
        shape = [(0, 0), *bulge, (0.3 * radius, body), (0, body)]
    parts = [part(lathe(shape), p["colour"], LIGHT, smooth=True)]
    parts.append(part(rod((0, 0, body), (0, 0, body + 0.05 * z), 0.012, 0.016), p["grip_colour"], PLASTIC, smooth=True))
    low, high = (0.66, 0.88) if p["style"] == "jug" else (0.45, 0.9)
    reach = size[0] * 0.5 if p["style"] == "stove" else radius * 1.25
    spout = rod((0.7 * top, 0, low * body), (reach, 0, high * body), 0.16 * radius + 0.006, 0.1 * radius)
    parts.append(part(spout, p["colour"], LIGHT, smooth=True))
    if p["style"] == "jug":
        grip = ear(radius, size[0] - radius * 2.25, 0.75 * body, 0.52 * body, p["grip_colour"], bool(p["angular"]))
    else:
        grip = ear(0.0, 0.75 * radius, 2 * 0.9 * radius, 0.0, p["grip_colour"], False)
    parts += moved(Model(grip), (0.0, 0.0, 0.0), turn=np.pi / 2).base if p["style"] == "jug" else _bail(grip, z, body)
    return Model(parts, placement="object")


def _bail(grip: list[Part], z: float, body: float) -> list[Part]:
    """A handle that was made upright beside the y axis, as an arch over the top from front to back."""
    points = np.concatenate([piece.mesh.vertices for piece in grip])
    span, rise = float(np.ptp(points[:, 2])), float(points[:, 1].max())
    factor = (z - 0.8 * body) / rise
    turned = []
    for piece in grip:
        mesh = piece.mesh.copy()
        v = mesh.vertices
        mesh.vertices = np.column_stack([v[:, 2] * min(1.0, 0.12 / span + 0.6), v[:, 0], 0.8 * body + factor * v[:, 1]])
        mesh.invert()
        turned.append(part(mesh, str(piece.finish), piece.density, piece.smooth))
    return turned


def draw_kettle(rng: Rng, index: int) -> Draw:
    """Electric jugs, and kettles for the stove."""
    style, deep = ["jug", "stove"][index % 2], float(rng.uniform(0.2, 0.25))
    size = (
        round(deep, 3),
        round(deep * (0.68 if style == "jug" else 0.76), 3),
        round(float(rng.uniform(0.19, 0.26)), 3),
    )
    p = {
        "style": style,
        "taper": round(float(rng.uniform(0.6, 0.95)), 3),
        "angular": bool(index % 4 == 0),
        "colour": pick(rng, APPLIANCE, GLAZES),
        "grip_colour": pick(rng, METALS[2:], WOODS),
    }
    return Draw("kettle", size, p)


def toaster(size: Size, p: dict[str, Any]) -> Model:
    """Slots along y, the lever at +x. Parameters: slots, edge (chamfer), feet, colours."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    foot = 0.05 * z
    parts = [
        part(box((a, a + 0.03), (b, b + 0.02), (0, foot)), DARK)
        for a in (-0.8 * x, 0.6 * x)
        for b in (-0.8 * y, 0.6 * y)
    ]
    parts.append(part(cushion((-x, -y, foot), (x - 0.02, y, z), float(p["edge"])), p["colour"], LIGHT))
    parts.append(
        part(
            box((-0.97 * x, x - 0.022), (-y - 0.001, y + 0.001), (foot, 0.2 * z)), p["trim_colour"], LIGHT, solid=False
        )
    )
    count = int(p["slots"])
    for b in (np.arange(count) - (count - 1) / 2) * 0.9 * size[1] / (count + 0.5):
        parts.append(
            part(box((-0.72 * x, 0.66 * x), (b - 0.012, b + 0.012), (z - 0.001, z + 0.001)), DARK, solid=False)
        )
    parts.append(part(box((x - 0.024, x), (-0.12 * y, 0.12 * y), (0.66 * z, 0.74 * z)), p["trim_colour"], PLASTIC))
    parts.append(part(box((x - 0.024, x - 0.019), (-0.03 * y, 0.03 * y), (0.25 * z, 0.8 * z)), DARK, solid=False))
    dial = rod((x - 0.022, 0.4 * y, 0.35 * z), (x - 0.006, 0.4 * y, 0.35 * z), 0.014)
    parts.append(part(dial, p["trim_colour"], PLASTIC, smooth=True))
    return Model(parts, placement="object")


def draw_toaster(rng: Rng, index: int) -> Draw:
    """For two or four slices."""
    slots = 2 if index % 3 else 4
    size = (
        round(float(rng.uniform(0.27, 0.36)), 3),
        round(float(rng.uniform(0.16, 0.2)) + 0.1 * (slots == 4), 3),
        round(float(rng.uniform(0.17, 0.21)), 3),
    )
    p = {
        "slots": slots,
        "edge": round(float(rng.uniform(0.012, 0.035)), 3),
        "colour": pick(rng, APPLIANCE, GLAZES),
        "trim_colour": pick(rng, METALS[1:3]),
    }
    return Draw("toaster", size, p)


def pan(size: Size, p: dict[str, Any]) -> Model:
    """A frying pan, its handle towards +y. Parameters: flare (foot / rim), rise (of the handle), lid, colours."""
    radius, z = size[0] / 2, size[2]
    reach = max(size[1] - size[0], 0.3 * radius)
    body = z * (0.62 if p["lid"] else 0.8)
    flare = float(p["flare"])
    outer = [(flare * radius, 0.0), (0.5 * (1 + flare) * radius, 0.4 * body), (radius, body)]
    parts = hollow(outer, min(0.004, 0.1 * body), p["colour"], p["inside"], METAL)
    start, end = 0.75 * body, body * (0.8 + float(p["rise"]))
    parts.append(
        part(
            rod((0, 0.94 * radius, start), (0, radius + reach, end), 0.008, 0.011),
            p["grip_colour"],
            PLASTIC,
            smooth=True,
        )
    )
    if p["lid"]:
        parts.append(
            part(
                lathe([(0, body), (radius, body), (0.5 * radius, 0.85 * z), (0, 0.87 * z)]),
                p["lid_colour"],
                METAL,
                smooth=True,
            )
        )
        parts.append(part(rod((0, 0, 0.82 * z), (0, 0, z), 0.012, 0.02), p["grip_colour"], PLASTIC, smooth=True))
    parts = moved(Model(parts), (0.0, -reach / 2, 0.0)).base
    return Model(parts, placement="object")


def draw_pan(rng: Rng, index: int) -> Draw:
    """Flat frying pans to sauce pans with a lid."""
    diameter, lid = float(rng.uniform(0.2, 0.3)), index % 3 == 2
    size = (
        round(diameter, 4),
        round(diameter + float(rng.uniform(0.15, 0.2)), 4),
        round(float(rng.uniform(0.11, 0.17) if lid else rng.uniform(0.05, 0.08)), 4),
    )
    p = {
        "flare": round(float(rng.uniform(0.75, 0.95)), 3),
        "rise": round(float(rng.uniform(0.1, 0.45)), 3),
        "lid": lid,
        "colour": pick(rng, METALS[:3], GLAZES[1:4]),
        "inside": pick(rng, METALS[:3]),
        "lid_colour": pick(rng, METALS[:2]),
        "grip_colour": pick(rng, METALS[2:3], WOODS[1:4]),
    }
    return Draw("pan", size, p)


def jar(size: Size, p: dict[str, Any]) -> Model:
    """A jar with a lid. Parameters: neck (share of the radius), lid (share of the height), knob, label, colours."""
    radius, z = size[0] / 2, size[2]
    top = z * (1 - float(p["lid"]))
    neck = float(p["neck"]) * radius
    outline = [
        (0, 0),
        (0.94 * radius, 0),
        (radius, 0.06 * top),
        (radius, 0.82 * top),
        (neck, 0.97 * top),
        (neck, top),
        (0, top),
    ]
    parts = [part(lathe(outline), p["colour"], 900.0, smooth=True)]
    cap = z if not p["knob"] else top + 0.6 * (z - top)
    parts.append(
        part(lathe([(0, top), (1.08 * neck, top), (1.08 * neck, cap), (0, cap)]), p["lid_colour"], 700.0, smooth=True)
    )
    if p["knob"]:
        parts.append(
            part(rod((0, 0, cap), (0, 0, z), 0.16 * radius, 0.24 * radius), p["lid_colour"], 700.0, smooth=True)
        )
    if p["label"]:
        band = lathe([(0, 0.25 * top), (1.004 * radius, 0.25 * top), (1.004 * radius, 0.6 * top), (0, 0.6 * top)])
        parts.append(part(band, p["label_colour"], smooth=True, solid=False))
    return Model(parts, symmetry="full", placement="object")


def draw_jar(rng: Rng, index: int) -> Draw:
    """Preserving jars, storage jars with a knob."""
    diameter = round(float(rng.uniform(0.075, 0.13)), 4)
    p = {
        "neck": round(float(rng.uniform(0.7, 0.95)), 3),
        "lid": round(float(rng.uniform(0.12, 0.24)), 3),
        "knob": bool(index % 2),
        "label": bool(index % 3 == 0),
        "colour": pick(rng, GLAZES),
        "lid_colour": pick(rng, WOODS, METALS, GLAZES),
        "label_colour": pick(rng, PAINTS[:2]),
    }
    return Draw("jar", (diameter, diameter, round(diameter * float(rng.uniform(1.1, 1.9)), 4)), p)
