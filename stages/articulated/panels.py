"""The panels that joints move: how large the front of a door or drawer is, how high, and about what it turns."""

from collections.abc import Container
from pathlib import Path
from typing import NamedTuple

import numpy as np

from stages.articulated.asset_folder import read_asset, urdf_of
from stages.articulated.forward_kinematics import frames_of, visual_bounds
from stages.articulated.model import JointModel, Matrix
from stages.articulated.urdf_reader import UrdfReader


class Panel(NamedTuple):
    """What a joint moves: front area (m^2), height of its centre (m), axis of the joint in the asset frame."""

    joint: str
    area: float
    height: float
    axis: Matrix


def read_panels(folder: Path, joints: Container[str]) -> list[Panel]:
    """The panels of the named joints of an asset, closed. A joint that moves nothing visible (a helper link) has none.

    Raises:
        InputError: the asset's files are missing or broken.
    """
    reader = UrdfReader(urdf_of(folder, read_asset(folder)), folder)
    frames = frames_of(reader.tree.root, reader.joints)
    panels = []
    for joint in reader.joints:
        if joint.type == "fixed" or joint.name not in joints:
            continue
        boxes = (visual_bounds(reader.visuals(link), frames[link]) for link in moved_by(joint, reader.joints))
        corners = [box for box in boxes if box is not None]
        if corners:
            low, high = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
            size = high - low
            axis = frames[joint.child][:3, :3] @ joint.axis
            panels.append(Panel(joint.name, float(size[1] * size[2]), float((low + high)[2] / 2), axis))
    return panels


def moved_by(joint: JointModel, joints: list[JointModel]) -> list[str]:
    """The link that a joint moves and all that is fixed to it, such as its handle."""
    links = [joint.child]
    for other in joints:  # parents before children
        if other.type == "fixed" and other.parent in links:
            links.append(other.child)
    return links
