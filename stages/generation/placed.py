"""Models of the library, sized, as meshes and what collides, and in their places as they pass from step to step.

In the asset frame, every joint closed. Asset folders never change: their names are keys of their content.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely import MultiPoint, Polygon
from trimesh import Trimesh

from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.articulated.model import RobotModel, list_collisions, measure_closed_box
from roomkin.stages.articulated.resizing import has_size, load_maker, resize_model
from roomkin.stages.articulated.urdf_writer import as_written
from roomkin.stages.contracts import Asset
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.generated import GAMMA
from roomkin.stages.contracts.library import Finish
from roomkin.stages.contracts.objects import Mounting, Objects
from roomkin.stages.contracts.types import FLOOR, UNNAMED
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import make_transform, wrap_angle, yaw_matrix
from roomkin.stages.geometry.masks import MIN_PIXELS


class Prism(NamedTuple):
    """A convex outline (n, 2) in the x-y plane, from height `low` to `high`; `vertices`: of what it is around, (m, 3).

    Exact for boxes and panels, a little generous for slanted legs.
    """

    outline: NDArray[np.float64]
    low: float
    high: float
    vertices: NDArray[np.float64]


@dataclass(frozen=True)
class Placed:
    """A model whose closed box is `box` (floor frame).

    folder: of the model. robot: the model at its size, unless that is the folder's. prisms: of its collision shapes, in
    the asset frame. support: 'floor', 'wall', the id of the object beneath, or 'unnamed': it stands on something that
    is no object of the scene; as extraction saw it until it is stacked. spread: standard deviations of the logarithms
    of fitted extents. place_spread: metres, of its fitted center. cousin: its rank in cousins.json. chosen: by
    a person. steps: what each step changed so far. doubts: what may be wrong. finish: parameters of the asset's recipe
    that are other than the library's.
    """

    id: str
    label: str
    asset: Asset
    folder: Path
    box: UprightBox
    mounting: Mounting
    support: str = FLOOR
    robot: RobotModel | None = None
    prisms: tuple[Prism, ...] = ()
    spread: tuple[float, float, float] | None = None
    place_spread: float | None = None
    moved: float = 0.0
    cousin: int | None = None
    chosen: bool = False
    steps: tuple[str, ...] = ()
    doubts: tuple[Doubt, ...] = ()
    finish: Finish = field(default_factory=dict)

    @property
    def center(self) -> NDArray[np.float64]:
        """Box center (3,)."""
        return self.box.center

    @property
    def size(self) -> NDArray[np.float64]:
        """Extents (3,) along the asset's own axes."""
        return self.box.size

    @property
    def wall_mounted(self) -> bool:
        """Whether it hangs on a wall (A.2, type 1)."""
        return self.mounting.hangs

    @property
    def held(self) -> bool:
        """Whether it cannot fall: what hangs on a wall, or stands on what nobody named."""
        return self.wall_mounted or self.support == UNNAMED

    @property
    def middle(self) -> NDArray[np.float64]:
        """Box center (3,) in the asset frame."""
        return (np.asarray(self.asset.box_min) + np.asarray(self.asset.box_max)) / 2

    @property
    def stretch(self) -> float:
        """How far the model is stretched, 1 or more: as a whole, or one axis against another, whatever is more.

        A sofa of 2 m is no stool: it would be squeezed to a fifth of its width.
        """
        scales = self.size / np.asarray(self.asset.size)
        middle = float(np.median(scales))
        return max(float(scales.max() / scales.min()), middle, 1 / middle)

    @property
    def pose(self) -> NDArray[np.float64]:
        """floor_from_asset (4, 4)."""
        turn = yaw_matrix(self.box.yaw)
        return make_transform(turn, self.center - turn @ self.middle)

    @property
    def collision_prisms(self) -> list[Prism]:
        """The prisms where it stands, in the floor frame."""
        middle, turn = self.middle, yaw_matrix(self.box.yaw)
        rise = self.center[2] - middle[2]
        found = []
        for outline, low, high, vertices in self.prisms:
            plan = (outline - middle[:2]) @ turn[:2, :2].T + self.center[:2]
            found.append(Prism(plan, low + rise, high + rise, (vertices - middle) @ turn.T + self.center))
        return found

    def shift(self, offset: ArrayLike) -> "Placed":
        """The item moved by `offset` (3,), metres."""
        return replace(self, box=replace(self.box, center=self.center + np.asarray(offset, dtype=float)))

    def change_box(self, step: str, box: UprightBox) -> "Placed":
        """The item in another box. A change is noted in its `steps`, with the name of the step."""
        what = describe_difference(self.box, box)
        return replace(self, box=box, steps=(*self.steps, f"{step}: {what}") if what else self.steps)


def describe_difference(before: UprightBox, after: UprightBox) -> str:
    """How one box differs from another, e.g. `turned 12.0°, 0.41 x 0.90 x 0.80 m, moved 2.1 cm`; empty: not at all.

    What rounds to no tenth of a degree or millimetre is no difference.
    """
    turn = float(np.rad2deg(wrap_angle(after.yaw - before.yaw)))
    shift = after.center - before.center
    found = [f"turned {turn:+.1f}°"] if round(turn, 1) else []
    if (after.size - before.size).round(3).any():
        found.append(" x ".join(f"{extent:.3f}" for extent in after.size) + " m")
    if shift[:2].round(3).any():
        found.append(f"moved {100 * float(np.linalg.norm(shift[:2])):.1f} cm")
    if round(shift[2], 3):
        found.append(f"{'raised' if shift[2] > 0 else 'lowered'} {100 * abs(float(shift[2])):.1f} cm")
    return ", ".join(found)


RGB = tuple[float, float, float]  # linear
SHADING = (0.3, 0.9)  # quantiles of lightness between which a surface is neither in shadow nor glaring; chosen
ROUNDS = 3  # in each the half of the pixels that is nearest to the median gives the next one; chosen


def measure_colors(rgb: NDArray[np.uint8], masks: NDArray[np.uint16], objects: Objects) -> dict[str, RGB]:
    """The color that most of every object has in the picture, by id; of what shows too few pixels none.

    The light's tint stays in it, as in the colors of floor and walls (look.json).

    Args:
        rgb: the picture (H, W, 3).
        masks: of the objects (H, W).
    """
    lab = cv2.cvtColor(rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB)
    pixels = {item.id: lab[masks == item.mask] for item in objects.objects}
    return {name: find_main_color(each) for name, each in pixels.items() if len(each) >= MIN_PIXELS}


def find_main_color(lab: NDArray[np.float32]) -> RGB:
    """The color of most of N pixels (N, 3), Lab, as linear rgb: away from shadows and glare, others left out."""
    low, high = np.quantile(lab[:, 0], SHADING)
    kept = lab[(lab[:, 0] >= low) & (lab[:, 0] <= high)]
    for _ in range(ROUNDS):
        far = np.linalg.norm(kept - np.median(kept, axis=0), axis=1)
        kept = kept[far <= np.median(far)]
    shown = cv2.cvtColor(np.median(kept, axis=0).astype(np.float32)[None, None], cv2.COLOR_LAB2RGB)[0, 0]
    r, g, b = (np.clip(shown.astype(float), 0, 1) ** GAMMA).round(3).tolist()
    return r, g, b


def paint(item: Placed, color: RGB | None) -> Placed:
    """The item in the color of its object, by its recipe; a model without one, and one of no known color, stays."""
    if color is None:
        return item
    if item.asset.recipe is None:
        return replace(item, steps=(*item.steps, "in its own colors: a model that is no recipe's cannot be painted"))
    before = item.asset.recipe
    painted = load_maker().paint(before, color)
    finish: Any = {key: value for key, value in painted.parameters.items() if before.parameters[key] != value}
    asset = item.asset.model_copy(update={"recipe": painted})
    return replace(item, asset=asset, finish=finish)


def resize(item: Placed) -> Placed:
    """The item with a model of the size of its box and that model's collision prisms, rounded as in its files."""
    if has_size(item.asset, item.size.tolist()):
        return replace(item, prisms=to_prisms(read_collisions(item.folder)))
    robot = resize_model(item.folder, item.asset, item.size.tolist()).robot
    pieces = list_collisions(as_written(robot))
    low, high = (measure_closed_box(robot).round(6) + 0.0).tolist()
    sized = {"box_min": tuple(low), "box_max": tuple(high), "mass": round(robot.mass, 4)}
    return replace(item, asset=item.asset.model_copy(update=sized), robot=robot, prisms=to_prisms(pieces))


def to_prisms(pieces: Iterable[Trimesh]) -> tuple[Prism, ...]:
    """Upright prisms around convex pieces; without those that have no area from above."""
    found = []
    for piece in pieces:
        vertices = np.asarray(piece.vertices, dtype=float)
        hull = MultiPoint(vertices[:, :2]).convex_hull
        if isinstance(hull, Polygon):
            low, high = vertices[:, 2].min(), vertices[:, 2].max()
            found.append(Prism(np.array(hull.exterior.coords)[:-1], float(low), float(high), vertices))
    return tuple(found)


@lru_cache(maxsize=64)
def read_collisions(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return list_collisions(read_model(folder))
