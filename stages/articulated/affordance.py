"""Which joint of an asset a task opens: one of a part type, with a handle that a gripper can hold (paper A.4)."""

import math
from pathlib import Path
from typing import NamedTuple

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts.library import Asset, FrontPanel, HandleKind, Joint
from roomkin.stages.contracts.parts import PARTS, HingeSide, PartType

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
    return [
        _affordance(asset, joint, joint.panel)
        for joint in asset.joints
        if joint.part_type == part and joint.handle and joint.panel and joint.panel.hinge in sides
    ]


def _affordance(asset: Asset, joint: Joint, panel: FrontPanel) -> Affordance:
    assert joint.handle is not None
    _, width, height = asset.size
    return Affordance(
        joint.name, joint.handle, panel.hinge, panel.height / height, panel.size[0] / width, panel.size[1] / height
    )
