"""The extents of a handle, from the shape of what its joint moves: no rays, no simulator."""

from pathlib import Path

import numpy as np

from roomkin.stages.articulated.asset_folder import urdf_of
from roomkin.stages.articulated.attributes import list_moved_links
from roomkin.stages.articulated.forward_kinematics import frames_of
from roomkin.stages.articulated.model import Matrix
from roomkin.stages.articulated.urdf_reader import UrdfReader
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.contracts.library import Asset
from roomkin.stages.geometry.frames import transform_points

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
