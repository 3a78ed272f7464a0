"""What a step of placing changed, in words: the story of an object, from its cloud to its place."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from stages.generation.placed import Placed
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import wrap_angle

LEAST, LEAST_TURN = 0.0005, 0.05  # metres, degrees: less is rounded away

Change = Callable[[UprightBox], UprightBox]


def difference(before: UprightBox, after: UprightBox) -> str:
    """How one box differs from another, e.g. `turned 12.0°, 0.41 x 0.90 x 0.80 m, moved 2.1 cm`; empty: not at all."""
    turn = float(np.rad2deg(wrap_angle(after.yaw - before.yaw)))
    size, shift = np.asarray(after.size, dtype=float), np.asarray(after.center, dtype=float) - before.center
    told = [f"turned {turn:+.1f}°"] if abs(turn) > LEAST_TURN else []
    if np.abs(size - before.size).max() > LEAST:
        told.append(" x ".join(f"{extent:.3f}" for extent in size) + " m")
    if np.abs(shift[:2]).max() > LEAST:
        told.append(f"moved {100 * float(np.linalg.norm(shift[:2])):.1f} cm")
    if abs(shift[2]) > LEAST:
        told.append(f"{'raised' if shift[2] > 0 else 'lowered'} {100 * abs(float(shift[2])):.1f} cm")
    return ", ".join(told)


def changed(box: UprightBox, changes: Iterable[tuple[str, Change]]) -> tuple[UprightBox, tuple[str, ...]]:
    """The box after some changes, each with its name, and what each of them did."""
    told = []
    for name, change in changes:
        before, box = box, change(box)
        if what := difference(before, box):
            told.append(f"{name}: {what}")
    return box, tuple(told)


def told(name: str, before: Sequence[Placed], after: Sequence[Placed]) -> list[Placed]:
    """The items after a step that looked at all of them, with what it did to each."""
    boxes = {item.id: item.box for item in before}
    what = {item.id: difference(boxes[item.id], item.box) for item in after}
    return [replace(item, steps=(*item.steps, f"{name}: {what[item.id]}")) if what[item.id] else item for item in after]
