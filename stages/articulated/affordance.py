"""Which joint of an asset a task opens (paper A.4): one of a part type, with a handle that a gripper can hold."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roomkin.stages.articulated.asset_folder import read_asset, urdf_of
from roomkin.stages.articulated.handle import list_moved_links
from roomkin.stages.articulated.model import Matrix, frames_of
from roomkin.stages.articulated.urdf_reader import UrdfReader
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.contracts.library import Asset, HandleKind
from roomkin.stages.contracts.parts import PARTS, HingeSide, PartType
from roomkin.stages.geometry.frames import transform_points

LARGE = 0.5  # a panel with at least this share of the largest panel's area is as good a target
FLAPS: tuple[HingeSide, ...] = ("bottom",)


class Affordance(NamedTuple):
    """A joint that a task can open, and what tells it from others.

    height, width, tall: of its front's center and its extents, as shares of the asset's box, so that assets which are
    loaded in the same box compare.
    """

    joint: str
    handle: HandleKind
    hinge: HingeSide
    height: float
    width: float
    tall: float

    @property
    def area(self) -> float:
        """Share of the box's front."""
        return self.width * self.tall

    def measure_difference(self, other: "Affordance") -> float:
        """How differently two fronts lie in the same box: 0 for the same place and extents."""
        extents = math.log(self.width / other.width), math.log(self.tall / other.tall)
        return abs(self.height - other.height) + sum(map(abs, extents))


def target_joint(
    folder: Path, part: PartType, like: Affordance | None = None, flaps: bool = False
) -> Affordance | None:
    """The joint of the asset in `folder` that the task opens; None if no joint will do.

    A door has an upright hinge (a flap that falls open is another motion: it counts with `flaps`, on an asset with no
    other door), a drawer slides, and either has a handle.
    For a cousin it is the one most like the twin's (`like`): the same hinge side first, then the same kind of handle,
    then the nearest height and extents. For the twin itself: of the large ones (half of the largest or more) the
    largest, then the one nearest to mid-height, then the first by name.
    """
    asset = read_asset(folder)
    able = _list_affordances(asset, part, PARTS[part].sides)
    if not able and flaps:
        able = _list_affordances(asset, part, FLAPS)
    if not able:
        return None
    if like is not None:

        def difference(one: Affordance) -> tuple[bool, bool, float, str]:
            return one.hinge != like.hinge, one.handle != like.handle, round(one.measure_difference(like), 3), one.joint

        return min(able, key=difference)
    largest = max(one.area for one in able)

    def order(one: Affordance) -> tuple[float, float, str]:
        # rounded, so that panels of equal size tie whatever their handles add
        return -round(one.area / largest, 1), round(abs(one.height - 0.5), 3), one.joint

    return min((one for one in able if one.area >= LARGE * largest), key=order)


def _list_affordances(asset: Asset, part: PartType, sides: tuple[HingeSide, ...]) -> list[Affordance]:
    _, width, height = asset.size
    return [
        Affordance(one.name, one.handle, at.hinge, at.height / height, at.size[0] / width, at.size[1] / height)
        for one in asset.joints
        if one.part_type == part and one.handle and (at := one.panel) and at.hinge in sides
    ]


COVERED = 0.4  # share of the front's area: more than a handle covers, less than its panel


def handle_extents(folder: Path, asset: Asset, joint: str) -> Matrix:
    """Lowest and highest corner (2, 3) of the handle on what a joint moves; asset frame, closed, metres.

    The handle is what lies in the front half of all that stands out of the panel. The panel is as deep as the surfaces
    that, counted from the foremost, cover `COVERED` of the front. Where nothing stands out it is the face: a button's.

    Args:
        folder: of the asset.
        joint: its name; it has a handle.
    """
    reader = UrdfReader(urdf_of(folder, asset), folder)
    children = {model.child for model in reader.joints}
    frames = frames_of(next(link for link in reader.tree.links if link not in children), reader.joints)
    moving = list_moved_links(next(model for model in reader.joints if model.name == joint), reader.joints)
    triangles = np.concatenate(
        [
            transform_points(frames[link], mesh.vertices)[mesh.faces]
            for link in moving
            for mesh in (visual.mesh for visual in reader.visuals(link))
        ]
    )
    points = triangles.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    (ay, az), (by, bz) = ((triangles[:, k, 1:] - triangles[:, 0, 1:]).T for k in (1, 2))
    facing, depths = np.abs(ay * bz - az * by) / 2, triangles[:, :, 0].mean(axis=1)
    order = np.argsort(-depths, kind="stable")
    covered = np.cumsum(facing[order]) / np.prod((high - low)[1:])
    panel = depths[order][min(np.searchsorted(covered, COVERED), len(order) - 1)]
    middle = (panel + high[0]) / 2 if high[0] - panel > THIN else high[0] - THIN
    handle = points[points[:, 0] > middle]
    return np.array([handle.min(axis=0), handle.max(axis=0)])
