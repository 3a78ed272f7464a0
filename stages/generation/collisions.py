"""Push things apart that overlap (paper A.3), by the shortest way, whole stacks at once; or let one rest in another."""

from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.optimize import linprog
from shapely import LineString, MultiPoint, Point, Polygon, affinity
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.generation.placed import Placed, Prism
from roomkin.stages.generation.stacking import find_stack, find_surface
from roomkin.stages.geometry.boxes import depth_behind, volume

Piece = NDArray[np.float64]  # (n, 3): vertices of a convex piece


def overlap_height(upper: Piece, lower: Piece) -> float | None:
    """How far `lower` reaches above the underside of `upper`, at worst, metres; None: nowhere is one above the other.

    The highest point of one hull above the lowest of the other at the same x and y: a linear programme in the weights
    of the vertices of both.
    """
    if (upper[:, :2].min(0) > lower[:, :2].max(0)).any() or (lower[:, :2].min(0) > upper[:, :2].max(0)).any():
        return None
    n, m = len(upper), len(lower)
    same_place = np.hstack([upper[:, :2].T, -lower[:, :2].T])
    weights = np.vstack([np.repeat([1.0, 0.0], [n, m]), np.repeat([0.0, 1.0], [n, m])])
    found = linprog(
        np.concatenate([upper[:, 2], -lower[:, 2]]), A_eq=np.vstack([same_place, weights]), b_eq=[0.0, 0.0, 1.0, 1.0]
    )
    return -float(found.fun) if found.success else None


def find_landing(upper: list[Piece], lower: list[Piece]) -> float | None:
    """How far `upper` rises (metres; negative: sinks) to lie on or in `lower`, let down from above.

    Args:
        upper, lower: convex pieces of both, in one frame, z up.

    Returns:
        None if neither is above the other anywhere.
    """
    heights = [overlap_height(a, b) for a, b in product(upper, lower)]
    return max((height for height in heights if height is not None), default=None)


CLEAR = 1e-4  # metres that a push goes beyond the border, so that rounding does not leave the pair touching
Pair = tuple[str, str]


@dataclass(frozen=True)
class Freed:
    """The items after all pushes, and the pairs that still overlap."""

    items: list[Placed]
    left: list[Pair]


class _Reach(NamedTuple):
    """How far the collision shapes of an item go from its center: from above, down, and up, metres."""

    radius: float
    low: float
    high: float


class _Forbidden(NamedTuple):
    """Shifts of one item at which it overlaps another, and, at these shifts and `CLEAR` beyond, is not clear of it.

    offset: (3,) of the other's center from its own, where they were found.
    """

    offset: NDArray[np.float64]
    overlaps: BaseGeometry
    unclear: BaseGeometry


@dataclass(frozen=True)
class _Scene:
    """Everything that a push has to look at. `nested`: what lies in what.

    Items are only shifted, so that what is found of their shapes holds in all later scenes: `reaches`, `found`.
    """

    items: dict[str, Placed]
    walls: list[Wall]
    options: GenerationConfig
    nested: frozenset[Pair] = frozenset()
    reaches: dict[str, _Reach] = field(default_factory=dict)
    found: dict[Pair, _Forbidden] = field(default_factory=dict)

    @property
    def supports(self) -> dict[str, str]:
        return {name: item.support for name, item in self.items.items()}

    def shapes(self, name: str) -> list[Prism]:
        return self.items[name].collision_prisms

    def reach(self, name: str) -> _Reach:
        if name not in self.reaches:
            prisms, center = self.shapes(name), self.items[name].center
            far = [float(np.linalg.norm(prism.outline - center[:2], axis=1).max()) for prism in prisms]
            low = min((prism.low for prism in prisms), default=0)
            high = max((prism.high for prism in prisms), default=0)
            self.reaches[name] = _Reach(max(far, default=-np.inf), low - center[2], high - center[2])
        return self.reaches[name]

    def are_near(self, a: str, b: str, limit: float) -> bool:
        """Whether two items may overlap once one of them is shifted by `limit` metres at most."""
        (x, y, z), one, other = self.items[b].center - self.items[a].center, self.reach(a), self.reach(b)
        over = min(one.high, other.high + z) - max(one.low, other.low + z)
        return bool(over > self.options.touch and np.hypot(x, y) < one.radius + other.radius + limit)

    def forbidden(self, a: str, b: str) -> _Forbidden:
        """The shifts of `a` at which it overlaps `b`."""
        offset = self.items[b].center - self.items[a].center
        known = self.found.get((a, b))
        if known is None or known.offset[2] != offset[2]:
            region = forbidden_shifts(self.shapes(a), self.shapes(b), self.options.touch)
            known = self.found[a, b] = _Forbidden(offset, region, region.buffer(CLEAR))
        x, y, _ = offset - known.offset
        return _Forbidden(offset, *(affinity.translate(each, x, y) for each in known[1:]))


def resolve_collisions(items: list[Placed], walls: list[Wall], options: GenerationConfig) -> Freed:
    """Move items apart until no pair overlaps, as far as possible.

    Each round frees one stack from everything around it, so that a push makes no new collision.
    Items at a wall slide along it; hanging ones move only if nothing else can.
    """
    scene = _Scene({item.id: item for item in items}, walls, options)
    for _ in range(options.push_rounds):
        pushed = _push_once(scene)
        if pushed is None:
            break
        scene = pushed
    ends = [(item, scene.items[item.id]) for item in items]
    freed = [replace(item.change_box("out of collisions", end.box), moved=end.moved) for item, end in ends]
    return Freed(freed, overlapping_pairs(scene))


def _push_once(scene: _Scene) -> _Scene | None:
    """The scene after the first push that is possible; None: nothing overlaps, or nothing can give way."""
    pairs = overlapping_pairs(scene)
    for pair in pairs:
        for name in _movers(pair, scene):
            push = shortest_push(name, scene, scene.options.push_limit)
            if push is not None:
                return _push(name, push, scene)
        nested = _nest(pair, scene) if scene.options.stack_tolerance is not None else None
        if nested is not None:
            return nested
    for name in (name for pair in pairs for name in _movers(pair, scene)):
        push = shortest_push(name, scene, scene.options.last_push_limit)
        if push is not None:
            return _push(name, push, scene)
    return None


def overlapping_pairs(scene: _Scene) -> list[Pair]:
    """Pairs of items whose collision shapes overlap by more than `touch`; what stands on a seat may be in the back."""
    near = (pair for pair in combinations(sorted(scene.items), 2) if scene.are_near(*pair, 0.0))
    here = Point(0, 0)
    return [pair for pair in near if pair not in scene.nested and scene.forbidden(*pair).overlaps.contains(here)]


def forbidden_shifts(mover: list[Prism], others: list[Prism], touch: float) -> BaseGeometry:
    """All shifts (dx, dy) of `mover` at which it overlaps `others` by more than `touch` metres.

    Convex outlines A + t and B meet if and only if t lies in the Minkowski difference B - A, which is
    the hull of the differences of their vertices; so the shortest way out is the nearest point of a
    polygon's border, for all pieces at once.
    """
    regions = []
    for a, b in product(mover, others):
        if min(a.high, b.high) - max(a.low, b.low) > touch:
            differences = (b.outline[None] - a.outline[:, None]).reshape(-1, 2)
            regions.append(MultiPoint(differences).convex_hull.buffer(-touch, join_style="mitre"))
    return shapely.union_all(regions)


def _movers(pair: Pair, scene: _Scene) -> list[str]:
    """The order in which items give way: what stands free, what stands at a wall, what hangs; small before large.

    What carries the other would take it along.
    """

    def rank_weight(name: str) -> tuple[int, float, str]:
        stack, item = find_stack(name, scene.supports), scene.items[name]
        held = 2 if item.wall_mounted else int(item.mounting.type == 3)
        return held, sum(volume(scene.items[n].box) for n in stack), name

    return sorted((name for name in pair if not set(pair) <= find_stack(name, scene.supports)), key=rank_weight)


def shortest_push(name: str, scene: _Scene, limit: float) -> NDArray[np.float64] | None:
    """The shortest shift (2,), `limit` metres at most, that frees an item's stack from all else; None: none does."""
    stack = sorted(find_stack(name, scene.supports))
    unclear = [
        scene.forbidden(member, other).unclear
        for member, other in product(stack, sorted(scene.items.keys() - stack))
        if scene.are_near(member, other, limit + CLEAR)
    ]
    free = allowed_shifts(name, scene, limit).difference(shapely.union_all(unclear))
    if free.is_empty:
        return None
    return np.array(nearest_points(Point(0, 0), free)[1].coords[0])


def allowed_shifts(name: str, scene: _Scene, limit: float) -> BaseGeometry:
    """Limits of an item's way: not far, not into walls, not off its support; along its wall only if it touches one."""
    item = scene.items[name]
    region: BaseGeometry = Point(0, 0).buffer(limit)
    touched = [wall for wall in scene.walls if wall.id in item.mounting.walls]
    if touched:
        x, y = np.asarray(touched[0].normal)[:2]
        region = LineString([(-y * limit, x * limit), (y * limit, -x * limit)])
    else:
        for member in sorted(find_stack(name, scene.supports)):
            region &= wall_limits(scene.items[member], scene.walls, 2 * limit)
    if item.support in scene.items:
        surface = find_surface(item, scene.items[item.support])
        region &= affinity.translate(surface.steady_region(item), -item.center[0], -item.center[1])
    return region


def wall_limits(item: Placed, walls: list[Wall], far: float) -> BaseGeometry:
    """Shifts, as far as `far` metres, that keep the item's box in front of every wall it stands in front of now."""
    region: BaseGeometry = Point(0, 0).buffer(far)
    for wall in walls:
        normal = np.asarray(wall.normal)
        if item.center @ normal < wall.offset:
            continue
        room = min(0.0, depth_behind(item.box, wall.normal, wall.offset))  # what is in the wall already may stay
        tangent = np.array([-normal[1], normal[0]])
        near, beyond = normal[:2] * room, normal[:2] * far
        side = tangent * far
        region &= Polygon([near + side, near - side, beyond - side, beyond + side])
    return region


def _push(name: str, push: NDArray[np.float64], scene: _Scene) -> _Scene:
    stack = find_stack(name, scene.supports)
    items = dict(scene.items)
    for member in stack:
        item = items[member].shift([*push, 0.0])
        items[member] = replace(item, moved=item.moved + float(np.linalg.norm(push)))
    return replace(scene, items=items)


def _nest(pair: Pair, scene: _Scene) -> _Scene | None:
    """The scene with what cannot be clear of its support, a can in a bowl, let down into the middle of it."""
    upper, lower = pair if scene.items[pair[0]].support == pair[1] else pair[::-1]
    item, carrier = scene.items[upper], scene.items[lower]
    if item.support != lower or item.wall_mounted:
        return None
    middle = find_surface(item, carrier).area.centroid
    scene = _push(upper, np.array([middle.x, middle.y]) - item.center[:2], scene)
    rise = find_landing(*([prism.vertices for prism in scene.shapes(name)] for name in (upper, lower)))
    items = dict(scene.items)
    for member in find_stack(upper, scene.supports):
        items[member] = items[member].shift([0, 0, rise or 0.0])
    return replace(scene, items=items, nested=scene.nested | {pair})
