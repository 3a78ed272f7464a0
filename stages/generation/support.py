"""What stands on what: the 70 % rule (paper A.3), with a check that it is on top and not merely in front."""

from collections.abc import Callable, Mapping

from stages.generation.placed import FLOOR, UNNAMED, Placed
from stages.generation.prisms import Surface
from stages.geometry.boxes import footprint

Beneath = Callable[[Placed, Placed], Surface]  # (item, what may carry it): what it would stand on


def sorted_by_height(items: list[Placed]) -> list[Placed]:
    """From low to high by the height of the box centre (A.3); ties by id, so that the order is always the same."""
    return sorted(items, key=lambda item: (item.center[2], item.id))


def overlap_share(upper: Placed, lower: Placed) -> float:
    """Shared footprint area as a share of the smaller of both footprints."""
    a, b = footprint(upper.box), footprint(lower.box)
    smaller = min(a.area, b.area)
    return float(a.intersection(b).area / smaller) if smaller > 0 else 0.0


def apart(item: Placed, other: Placed) -> float:
    """Distance of their footprints, metres."""
    return float(footprint(item.box).distance(footprint(other.box)))


def support_tree(items: list[Placed], overlap: float, tolerance: float | None, beneath: Beneath) -> dict[str, str]:
    """The support of every item: 'floor', the id of the highest one beneath it, or 'unnamed'.

    Args:
        items: sorted from low to high.
        overlap: share of the smaller footprint that must be exceeded (paper: 0.7).
        tolerance: metres by which the upper bottom may lie below the surface. Without it (None, as
            in the paper) a chair that is tucked under a table ends up standing on it. With it, what is found
            at the height of a top and over its edge, or so far beside it, stands on that, not on the floor: far
            away, noise moves it there; and what is farther above all of it stands on something that nobody named
            (a shelf).
    """
    supports = {}
    for index, item in enumerate(items):
        carriers = [
            lower
            for lower in items[:index]
            if overlap_share(item, lower) > overlap
            and (tolerance is None or item.bottom >= beneath(item, lower).height - tolerance)
        ]
        if not carriers and tolerance is not None and item.bottom > tolerance and not item.wall_mounted:
            level = [
                low
                for low in items[:index]
                if apart(item, low) <= tolerance and abs(item.bottom - beneath(item, low).height) <= tolerance
            ]
            carriers = sorted(level, key=lambda low: (overlap_share(item, low), -apart(item, low), low.id))[-1:]
        highest = max(((beneath(item, lower).height, lower.id) for lower in carriers), default=(0.0, FLOOR))
        top = max((lower.top for lower in carriers), default=0.0)  # a stool's may have become a chair's back
        above = tolerance is not None and item.bottom > top + tolerance and not item.wall_mounted
        supports[item.id] = UNNAMED if above else highest[1]
    return supports


def stack_of(base: str, supports: Mapping[str, str]) -> set[str]:
    """Ids of an item and of everything that it carries, directly or not."""
    stack = {base}
    while True:
        more = {name for name, support in supports.items() if support in stack} - stack
        if not more:
            return stack
        stack |= more


def carried(
    ordered: list[Placed], supports: dict[str, str], told: Mapping[str, str]
) -> tuple[list[Placed], dict[str, str]]:
    """Items and supports with those that a person says; what carries comes before what it carries.

    What would carry itself by that stands on the floor, unless it was told as well.
    """
    supports = supports | {name: below for name, below in told.items() if below in {FLOOR, *supports}}
    for name in told:
        beneath, seen = supports.get(name, FLOOR), {name}
        while beneath in supports and beneath not in seen:
            seen.add(beneath)
            if supports[beneath] == name:
                supports[beneath] = FLOOR
            beneath = supports[beneath]

    def height(name: str) -> int:
        return 1 + height(supports[name]) if name in supports else 0

    return sorted(ordered, key=lambda item: height(item.id)), supports
