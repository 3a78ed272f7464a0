"""A procedural model before it is written: parts with colour and density, some of them on joints."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from stages.contracts.library import HandleKind
from stages.geometry.solids import DENSITY as WOOD
from stages.procedural.finishes import RGB, Finish, Surface, finish_of
from stages.procedural.shapes import bounds_of

Size = tuple[float, float, float]
Symmetry = Literal["none", "half_turn", "third_turn", "quarter_turn", "full"]
Placement = Literal["floor", "object", "wall"]

METAL, STEEL, CERAMIC, GLASS = 2700.0, 7800.0, 2200.0, 2400.0  # kg / m^3
EXACT = 1e-9  # a model that fits as well as this is left as it is
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
    def colour(self) -> RGB:
        """Linear rgb."""
        return self.finish.colour

    @property
    def pieces(self) -> tuple[Trimesh, ...]:
        """The convex pieces that PhysX sees."""
        return (self.mesh,) if self.collisions is None else self.collisions


@dataclass(frozen=True)
class Moving:
    """Parts on a joint of the base, drawn closed, in the asset frame. `axis` points so that opening is positive."""

    name: str
    role: Literal["door", "drawer"]
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


def parts_of(model: Model) -> Iterable[Part]:
    """All parts, moving ones last."""
    yield from model.base
    for moving in model.moving:
        yield from moving.parts


def moved(model: Model, by: Sequence[float], suffix: str = "", turn: float = 0.0) -> Model:
    """The model turned about z, then moved, so that it can be a part of another; `suffix` goes to its joints' names."""
    transform = np.eye(4)
    transform[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    transform[:3, 3] = by

    def move(mesh: Trimesh) -> Trimesh:
        return Trimesh(mesh.vertices @ transform[:3, :3].T + transform[:3, 3], mesh.faces, process=False)

    def move_part(piece: Part) -> Part:
        pieces = None if piece.collisions is None else tuple(move(mesh) for mesh in piece.collisions)
        return replace(piece, mesh=move(piece.mesh), collisions=pieces)

    def move_joint(moving: Moving) -> Moving:
        x, y, z = (transform[:3, :3] @ moving.origin + transform[:3, 3]).tolist()
        a, b, c = (transform[:3, :3] @ moving.axis).tolist()
        parts = [move_part(piece) for piece in moving.parts]
        return replace(moving, name=f"{moving.name}{suffix}", parts=parts, origin=(x, y, z), axis=(a, b, c))

    return replace(
        model, base=[move_part(piece) for piece in model.base], moving=[move_joint(moving) for moving in model.moving]
    )


def bounds(model: Model) -> NDArray[np.float64]:
    """Closed box of the visible geometry, (2, 3)."""
    return bounds_of([piece.mesh for piece in parts_of(model)])


def fitted(model: Model, size: Size) -> Model:
    """The model scaled and moved to fill exactly x in +-size_x/2, y in +-size_y/2, z in 0..size_z.

    Generators aim at `size` themselves, so that the scale is close to 1 and panels keep their thickness.
    """
    low, high = bounds(model)
    scale = np.array(size) / (high - low)
    shift = np.array([-size[0] / 2, -size[1] / 2, 0.0]) - scale * low
    if np.abs(scale - 1.0).max() < EXACT and np.abs(shift).max() < EXACT:
        return model

    def fit_mesh(mesh: Trimesh) -> Trimesh:
        return Trimesh(mesh.vertices * scale + shift, mesh.faces, process=False)

    def fit_part(piece: Part) -> Part:
        pieces = None if piece.collisions is None else tuple(fit_mesh(mesh) for mesh in piece.collisions)
        return replace(piece, mesh=fit_mesh(piece.mesh), collisions=pieces)

    def fit_moving(moving: Moving) -> Moving:
        x, y, z = (np.array(moving.origin) * scale + shift).tolist()
        stretch = float(np.abs(np.array(moving.axis)) @ scale) if moving.role == "drawer" else 1.0
        parts = [fit_part(piece) for piece in moving.parts]
        return replace(moving, parts=parts, origin=(x, y, z), upper=moving.upper * stretch)

    return replace(
        model, base=[fit_part(piece) for piece in model.base], moving=[fit_moving(moving) for moving in model.moving]
    )
