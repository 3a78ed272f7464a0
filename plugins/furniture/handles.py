"""Handles that a parallel gripper can hold: 8-16 mm thick, standing out far enough for a finger on either side."""

from typing import Literal, NamedTuple

import numpy as np

from roomkin.plugins.furniture.finishes import Surface
from roomkin.plugins.furniture.model import METAL, Part, part
from roomkin.plugins.furniture.shapes import hull, lathe, rod, rotate, slab, translate
from roomkin.stages.contracts.library import HandleKind

Style = Literal["bar", "square_bar", "knob", "arch", "edge", "none"]


class Pull(NamedTuple):
    """A style of handle: how far it sticks out (metres), its kind, and the share of sampled cabinets that have it."""

    protrusion: float
    kind: HandleKind | None
    share: float = 0.0


STYLES: dict[Style, Pull] = {
    "bar": Pull(0.038, "bar", 0.3),
    "square_bar": Pull(0.036, "bar", 0.2),
    "knob": Pull(0.034, "knob", 0.2),
    "arch": Pull(0.040, "arch", 0.2),
    "edge": Pull(0.032, "edge", 0.1),
    "none": Pull(0.0, None),
}
HANDLES = [style for style, pull in STYLES.items() if pull.share]
HANDLE_SHARES = [STYLES[style].share for style in HANDLES]


def handle_parts(
    style: Style,
    at: tuple[float, float, float],
    along: Literal["y", "z"],
    length: float,
    protrusion: float,
    color: Surface,
) -> list[Part]:
    """Parts of a handle on a panel that faces +x.

    Args:
        at: point on the panel's face at the handle's middle.
        along: direction of its length: z on doors, y on drawers.
        length: metres; a knob ignores it.
        protrusion: distance from face to the handle's front.
    """
    if style == "none":
        return []
    make = {"bar": _bar, "square_bar": _square_bar, "knob": _knob, "arch": _arch, "edge": _edge}[style]
    parts = make(max(length, 0.06), protrusion, color)
    if along == "y":
        parts = [part(rotate(p.mesh, np.pi / 2, [1, 0, 0]), color, p.density, p.smooth) for p in parts]
    return [part(translate(p.mesh, at), color, p.density, p.smooth) for p in parts]


def _bar(length: float, out: float, color: Surface) -> list[Part]:
    radius = 0.0055
    x, inset = out - radius, length * 0.38
    posts = [rod((-0.004, 0, z), (x, 0, z), 0.004) for z in (-inset, inset)]
    bar = rod((x, 0, -length / 2), (x, 0, length / 2), radius)
    return [part(mesh, color, METAL, smooth=True) for mesh in (bar, *posts)]


def _square_bar(length: float, out: float, color: Surface) -> list[Part]:
    thickness, width = 0.010, 0.013
    middle = (out - 0.003) / 2 - 0.002
    bar = slab((out - thickness / 2, 0, 0), (thickness, width, length))
    posts = [slab((middle, 0, z), (out - 0.001, width, 0.012)) for z in (0.006 - length / 2, length / 2 - 0.006)]
    return [part(mesh, color, METAL) for mesh in (bar, *posts)]


def _edge(length: float, out: float, color: Surface) -> list[Part]:
    """A profile along the panel that two fingers take hold of from either side."""
    return [part(slab(((out - 0.004) / 2, 0, 0), (out + 0.004, 0.010, length)), color, METAL)]


def _knob(length: float, out: float, color: Surface) -> list[Part]:
    head = lathe(
        [(0, out * 0.45), (0.009, out * 0.45), (0.015, out * 0.68), (0.015, out * 0.82), (0.010, out), (0, out)], 16
    )
    meshes = [rod((-0.004, 0, 0), (out * 0.5, 0, 0), 0.0065), rotate(head, np.pi / 2, [0, 1, 0])]
    return [part(mesh, color, METAL, smooth=True) for mesh in meshes]


def _arch(length: float, out: float, color: Surface) -> list[Part]:
    half, thickness, width = length / 2, 0.010, 0.014
    angles = np.linspace(0, np.pi, 9)
    outline = np.column_stack([out * np.sin(angles) ** 0.7, -half * np.cos(angles)])
    inner = np.column_stack([np.maximum(outline[:, 0] - thickness, -0.004), outline[:, 1] * (1 - 0.009 / half)])
    outline[[0, -1], 0] = -0.004
    pieces = []
    for k in range(len(angles) - 1):
        corners = [outline[k], outline[k + 1], inner[k], inner[k + 1]]
        pieces.append(hull([(x, y, z) for x, z in corners for y in (-width / 2, width / 2)]))
    return [part(mesh, color, METAL) for mesh in pieces]
