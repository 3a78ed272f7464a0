"""A procedural model before it is written: parts with color and density, some of them on joints."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from roomkin.plugins.furniture.finishes import RGB, Finish, Surface, finish_of
from roomkin.plugins.furniture.shapes import bounds_of
from roomkin.stages.contracts.library import HandleKind, Placement, Symmetry
from roomkin.stages.contracts.parts import PARTS, PartType
from roomkin.stages.geometry.frames import ROUNDING
from roomkin.stages.geometry.solids import DENSITY as WOOD

Size = tuple[float, float, float]
Array = NDArray[np.float64]

METAL, STEEL, CERAMIC, GLASS = 2700.0, 7800.0, 2200.0, 2400.0  # kg / m^3
FOAM, PLASTIC, PAPER, FILLED = 60.0, 1000.0, 700.0, 900.0  # FILLED: a vessel and what is in it, wax


@dataclass(frozen=True)
class Part:
    """One solid of one finish. `collisions` are its convex pieces; None: the mesh is convex itself; (): none."""

    mesh: Trimesh
    finish: Finish
    density: float = WOOD
    collisions: tuple[Trimesh, ...] | None = None
    smooth: bool = False

    @property
    def color(self) -> RGB:
        """Linear rgb."""
        return self.finish.color

    @property
    def pieces(self) -> tuple[Trimesh, ...]:
        """The convex pieces that PhysX sees."""
        return (self.mesh,) if self.collisions is None else self.collisions


@dataclass(frozen=True)
class Moving:
    """Parts on a joint of the base, drawn closed, in the asset frame. `axis` points so that opening is positive."""

    name: str
    part_type: PartType
    parts: list[Part]
    origin: tuple[float, float, float]
    axis: tuple[float, float, float]
    upper: float
    handle: HandleKind | None = None


@dataclass(frozen=True)
class Model:
    """The result of a generator: z up, front towards +x."""

    base: list[Part]
    moving: list[Moving] = field(default_factory=list)
    symmetry: Symmetry = "none"
    placement: Placement = "floor"


def part(mesh: Trimesh, surface: Surface, density: float = WOOD, smooth: bool = False, solid: bool = True) -> Part:
    """A convex part; `solid=False`: seen, but not touched."""
    return Part(mesh, finish_of(surface), density, None if solid else (), smooth)


class Parts(list[Part]):
    """Parts put together one by one."""

    def add(
        self, mesh: Trimesh, surface: Surface, density: float = WOOD, smooth: bool = False, solid: bool = True
    ) -> None:
        """Add a convex part, see `part`."""
        self.append(part(mesh, surface, density, smooth, solid))


def parts_of(model: Model) -> Iterable[Part]:
    """All parts, moving ones last."""
    yield from model.base
    for moving in model.moving:
        yield from moving.parts


def move_model(model: Model, by: Sequence[float], suffix: str = "", turn: float = 0.0) -> Model:
    """The model turned about z, then moved, so that it can be a part of another; `suffix` goes to its joints' names."""
    rotation = np.eye(3)
    rotation[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]

    def move_joint(moving: Moving) -> Moving:
        a, b, c = (rotation @ moving.axis).tolist()
        return replace(moving, name=f"{moving.name}{suffix}", axis=(a, b, c))

    return _map_points(model, lambda points: points @ rotation.T + np.asarray(by), move_joint)


def bounds(model: Model) -> Array:
    """Closed box of the visible geometry, (2, 3)."""
    return bounds_of([piece.mesh for piece in parts_of(model)])


def fit_model(model: Model, size: Size) -> Model:
    """The model scaled and moved to fill exactly x in +-size_x/2, y in +-size_y/2, z in 0..size_z.

    Generators aim at `size` themselves, so that the scale is close to 1 and panels keep their thickness.
    """
    low, high = bounds(model)
    scale = np.array(size) / (high - low)
    shift = np.array([-size[0] / 2, -size[1] / 2, 0.0]) - scale * low
    if np.abs(scale - 1.0).max() < ROUNDING and np.abs(shift).max() < ROUNDING:
        return model

    def stretch_joint(moving: Moving) -> Moving:
        stretch = float(np.abs(np.array(moving.axis)) @ scale) if PARTS[moving.part_type].joint == "prismatic" else 1.0
        return replace(moving, upper=moving.upper * stretch)

    return _map_points(model, lambda points: points * scale + shift, stretch_joint)


def _map_points(model: Model, at: Callable[[Array], Array], on_joint: Callable[[Moving], Moving]) -> Model:
    """The model with all points (N, 3) where `at` puts them, and what else changes of its joints."""

    def mesh(old: Trimesh) -> Trimesh:
        return Trimesh(at(old.vertices), old.faces, process=False)

    def parts(old: list[Part]) -> list[Part]:
        pieces = [None if each.collisions is None else tuple(map(mesh, each.collisions)) for each in old]
        return [replace(each, mesh=mesh(each.mesh), collisions=own) for each, own in zip(old, pieces, strict=True)]

    def joint(old: Moving) -> Moving:
        x, y, z = at(np.array(old.origin)).tolist()
        return replace(on_joint(old), parts=parts(old.parts), origin=(x, y, z))

    return replace(model, base=parts(model.base), moving=list(map(joint, model.moving)))
