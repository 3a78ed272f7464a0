"""Doubts about a scene, and mere notes, from its files: for the pages of the report and of corrections.

A doubt is what a person can mend: `roomkin.stages.contracts.doubt` has all of them with their limits.
"""

import math
from collections.abc import Collection
from typing import NamedTuple

from roomkin.stages.contracts.cousins import ObjectCousins
from roomkin.stages.contracts.doubt import MEND, Cause, Doubt, DoubtKind, sort_by_chance
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.objects import Objects, SceneObject

AS_NEAR = 0.05  # share by which a second model is farther than the first
ANOTHER_SIZE = 0.3  # share by which an extent differs from the cloud's


def mountings_agree(item: SceneObject) -> bool:
    """Whether the stated mounting is the one that geometry finds; the order of walls does not count."""
    stated, measured = item.mounting, item.measured_mounting
    assert stated is not None and measured is not None
    return stated.type == measured.type and set(stated.walls) == set(measured.walls)


class Group(NamedTuple):
    """Doubts of one cause: what a person can do, and the objects with the doubt about each."""

    cause: Cause
    mend: str
    items: list[tuple[str, str]]


def group_doubts(found: Collection[tuple[str, Doubt]]) -> list[Group]:
    """Group pairs of object and doubt by cause."""
    groups = []
    for cause, mend in MEND.items():
        items: dict[str, list[str]] = {}
        for about, doubt in found:
            if doubt.cause == cause:
                items.setdefault(about, []).append(doubt.what)
        if items:
            groups.append(Group(cause, mend, [(about, "; ".join(each)) for about, each in items.items()]))
    return groups


def collect_doubts(
    entry: ObjectCousins, item: SceneObject, placed: PlacedObject | None, objects: Objects
) -> list[Doubt]:
    """Doubts about an object that a person can mend, likeliest first; nothing that a person has stated."""
    found = list(entry.doubts)
    if entry.cousins and not entry.cousins[0].fits and not (placed is not None and placed.chosen):
        found.append(DoubtKind.NO_FIT.of())
    found += [one for one in item.doubts if not (one.cause == "size" and "size" in item.told)]
    if item.note:
        found.append(DoubtKind.MOUNTING_UNCLEAR.of(note=item.note))
    if item.measured_mounting is not None and "mounting" not in item.told and not mountings_agree(item):
        found.append(DoubtKind.MOUNTING_DIFFERS.of(found=item.measured_mounting.words))
    if "size" not in item.told and (placed is None or placed.size_spread is None):  # else the fit says how sure it is
        if item.points < DoubtKind.FEW_POINTS.threshold:
            found.append(DoubtKind.FEW_POINTS.of(points=item.points))
        if _is_cut(item, objects):
            found.append(DoubtKind.CUT_OFF.of())
    if placed is None:
        differs = entry.cousins[0].differs if entry.cousins else ""
        return sort_by_chance(found + ([DoubtKind.OPENINGS.of(what=differs)] if differs else []))
    found += placed.doubts
    if "size" not in item.told and (juts := _measure_protrusion(placed, item)) > DoubtKind.JUTS.threshold:
        found.append(DoubtKind.JUTS.of(distance=100 * juts))
    if placed.moved > DoubtKind.PUSHED.threshold:
        found.append(DoubtKind.PUSHED.of(distance=100 * placed.moved))
    if placed.settled_shift is not None and placed.settled_shift > DoubtKind.SHIFTED.threshold:
        found.append(DoubtKind.SHIFTED.of(distance=100 * placed.settled_shift))
    return sort_by_chance(found)


def measure_side(item: SceneObject, placed: PlacedObject | None) -> float:
    """The largest side of a thing's box, m^2, as placed, else as measured; 1: it has none.

    Times the chance that it is wrong this is the harm of a doubt: in metres, as whoever uses the scene meets it; in
    pixels a mug near the camera is as large as a sofa.
    """
    if placed is not None and placed.status == "ok":
        size = placed.size
    elif item.box is not None:
        size = item.box.size
    else:
        return 1.0
    return math.prod(size) / min(size)


def collect_notes(entry: ObjectCousins, item: SceneObject, placed: PlacedObject | None) -> list[str]:
    """Notes about an object that need no action."""
    found = [entry.note] if entry.note else []
    chosen = placed is not None and placed.chosen
    first, *others = entry.cousins
    if not chosen and others and first.distance > 0 and others[0].distance < (1 + AS_NEAR) * first.distance:
        found.append(f"a second model is as near: {others[0].asset.replace('_', ' ')}")
    if placed is not None and placed.status == "ok" and item.box is not None and "size" not in item.told:
        ours, clouds = sorted(placed.size[:2]), sorted(item.box.size[:2])
        if any(abs(a / max(b, 1e-6) - 1) > ANOTHER_SIZE for a, b in zip(ours, clouds, strict=True)):
            found.append("placed with another depth or width than its cloud has: the far side is hidden")
    return found


def _measure_protrusion(placed: PlacedObject, item: SceneObject) -> float:
    """Metres by which a model reaches farther to its front than what is seen of the object, as it is deeper.

    0: its front faces away from the camera, which stands at x = y = 0; there nothing was seen.
    """
    if placed.status != "ok" or item.box is None:
        return 0.0
    c, s, turn = math.cos(placed.yaw), math.sin(placed.yaw), placed.yaw - item.box.yaw
    (x, y, _), (u, v, _) = item.box.center, placed.position
    if c * x + s * y >= 0:
        return 0.0
    deeper = placed.size[0] - abs(math.cos(turn)) * item.box.size[0] - abs(math.sin(turn)) * item.box.size[1]
    return max(0.0, min(deeper, c * (u - x) + s * (v - y) + deeper / 2))


def _is_cut(item: SceneObject, objects: Objects) -> bool:
    """Whether its mask touches the picture's border."""
    if item.pixels is None:
        return False
    x0, y0, x1, y1 = item.pixels
    return x0 == 0 or y0 == 0 or x1 == objects.width or y1 == objects.height
