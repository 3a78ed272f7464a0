"""Push overlapping things apart in the x-y plane (paper A.3): by the shortest way, whole stacks at once, with a cap."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPoint, Point, Polygon, affinity
from shapely.geometry.base import BaseGeometry
from shapely.ops import nearest_points

from stages.config.generation import GenerationConfig
from stages.contracts.objects import Wall
from stages.generation.nesting import find_landing
from stages.generation.placed import Placed, Prism
from stages.generation.stacking import find_stack
from stages.generation.surfaces import find_surface
from stages.geometry.boxes import depth_behind, footprint, volume

CLEAR = 1e-4  # metres that a push goes beyond the border, so that rounding does not leave the pair touching
Pair = tuple[str, str]


@dataclass(frozen=True)
class Freed:
    """The items after all pushes, and the pairs that still overlap."""

    items: list[Placed]
    left: list[Pair]


@dataclass(frozen=True)
class _Scene:
    """Everything that a push has to look at. `nested`: what lies in what."""

    items: dict[str, Placed]
    walls: list[Wall]
    options: GenerationConfig
    nested: frozenset[Pair] = frozenset()

    @property
    def supports(self) -> dict[str, str]:
        return {name: item.support for name, item in self.items.items()}

    def shapes(self, name: str) -> list[Prism]:
        return self.items[name].collision_prisms


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
    pairs = []
    for a, b in combinations(sorted(scene.items), 2):
        if (a, b) in scene.nested:
            continue
        first, second = scene.items[a], scene.items[b]
        if min(first.top, second.top) - max(first.bottom, second.bottom) <= scene.options.touch:
            continue
        if not footprint(first.box).intersects(footprint(second.box)):
            continue
        if forbidden_shifts(scene.shapes(a), scene.shapes(b), scene.options.touch).contains(Point(0, 0)):
            pairs.append((a, b))
    return pairs


def forbidden_shifts(mover: list[Prism], others: list[Prism], touch: float) -> BaseGeometry:
    """All shifts (dx, dy) of `mover` at which it overlaps `others` by more than `touch` metres.

    Convex outlines A + t and B meet if and only if t lies in the Minkowski difference B - A, which is
    the hull of the differences of their vertices; so the shortest way out is the nearest point of a
    polygon's border, for all pieces at once.
    """
    regions = []
    for a in mover:
        for b in others:
            if min(a.high, b.high) - max(a.low, b.low) <= touch:
                continue
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
    mover = [prism for member in stack for prism in scene.shapes(member)]
    others = [prism for other in sorted(scene.items) if other not in stack for prism in scene.shapes(other)]
    free = allowed_shifts(name, scene, limit).difference(
        forbidden_shifts(mover, others, scene.options.touch).buffer(CLEAR)
    )
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
