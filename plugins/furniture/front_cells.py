"""Divide a front into cells: columns of cells, or rows of cells, of doors, drawers, open shelves..."""

from typing import Literal, NamedTuple

Span = tuple[float, float]
CellKind = Literal["door", "drawer", "open", "flap", "panel"]


class FrontCell(NamedTuple):
    """One cell of the front. `hinge` is -1 or +1: the side (low or high y) on which a door hangs."""

    kind: CellKind
    y: Span
    z: Span
    hinge: int


def cells(
    layout: list[list[CellKind]],
    major: Literal["columns", "rows"],
    y: Span,
    z: Span,
    weights: dict[CellKind, float],
    hinge: int,
    column_weights: list[float] | None = None,
    row_weights: list[float] | None = None,
) -> list[FrontCell]:
    """Cells of the rectangle y x z.

    Args:
        layout: with `columns`, one list per column (low y first) of kinds from the top down; with `rows`, one list
            per row from the top down of kinds from low y to high y.
        weights: share of the height that each kind asks for.
        hinge: side of the doors that stand alone in their row; others hang on the outer side of their pair.
    """
    found = []
    if major == "columns":
        widths, doors = column_weights or [1.0] * len(layout), ["door" in column for column in layout]
        for index, (column, across) in enumerate(zip(layout, _split(y, widths), strict=True)):
            heights = _split((z[1], z[0]), [weights[kind] for kind in column])
            for kind, (top, bottom) in zip(column, heights, strict=True):
                found.append(FrontCell(kind, across, (bottom, top), _hinge(doors, index, hinge)))
        return found
    heights = _split((z[1], z[0]), row_weights or [max(weights[kind] for kind in row) for row in layout])
    for row, (top, bottom) in zip(layout, heights, strict=True):
        for index, (kind, across) in enumerate(zip(row, _split(y, [1.0] * len(row)), strict=True)):
            found.append(FrontCell(kind, across, (bottom, top), _hinge([k == "door" for k in row], index, hinge)))
    return found


def _split(span: Span, weights: list[float]) -> list[Span]:
    total, start, parts = sum(weights), span[0], []
    for weight in weights:
        end = start + (span[1] - span[0]) * weight / total
        parts.append((start, end))
        start = end
    return parts


def _hinge(doors: list[bool], index: int, alone: int) -> int:
    """Side on which a door hangs. Doors pair up from low y on and open from the middle of their pair; the last of an
    odd number hangs on the outer side; a single one on the side `alone`."""
    place, count = sum(doors[:index]), sum(doors)
    if count == 1:
        return alone
    left_over = count % 2 == 1 and place == count - 1
    return 1 if place % 2 == 1 or left_over else -1
