"""Which joint of an asset a task opens: doors and drawers with a handle that a gripper can hold (paper A.4)."""

from pathlib import Path
from typing import Literal

from stages.articulated.asset_folder import read_asset
from stages.articulated.panels import Panel, read_panels

Task = Literal["door", "drawer"]
LARGE = 0.5  # a panel with at least this share of the largest panel's area is as good a target
UPRIGHT = 0.9  # |z| of a hinge: a flap that falls open is another motion than a door


def target_joint(folder: Path, task: Task, like: Panel | None = None) -> Panel | None:
    """The joint of the asset in `folder` that the task opens; None if no joint will do.

    A door has an upright hinge, a drawer slides, and either has a handle link. Among those with a large
    panel (half of the largest or more) the choice is one that turns the same way as the twin's (`like`),
    then the largest, then the one nearest to mid-height, then the first by name.
    """
    asset = read_asset(folder)
    wanted = ("revolute", "door") if task == "door" else ("prismatic", "drawer")
    joints = {joint.name for joint in asset.joints if (joint.type, joint.role) == wanted and joint.handle_link}
    if not joints:
        return None
    panels = [panel for panel in read_panels(folder, joints) if task == "drawer" or abs(panel.axis[2]) >= UPRIGHT]
    if not panels:
        return None
    middle = (asset.box_min[2] + asset.box_max[2]) / 2
    largest = max(panel.area for panel in panels)

    def order(panel: Panel) -> tuple[bool, float, float, str]:
        other_way = like is not None and float(panel.axis @ like.axis) < 0
        # rounded, so that panels of equal size tie whatever their handles add
        return other_way, -round(panel.area / largest, 1), round(abs(panel.height - middle), 3), panel.joint

    return min((panel for panel in panels if panel.area >= LARGE * largest), key=order)
