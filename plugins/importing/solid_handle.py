"""Collision shapes of handles: where a convex hull closes the gap behind a handle, decompose its visual mesh."""

from dataclasses import replace

import numpy as np
import trimesh
from trimesh import Trimesh

from roomkin.stages.articulated.attributes import list_moved_links, merge_visuals
from roomkin.stages.articulated.forward_kinematics import link_frames
from roomkin.stages.articulated.handle import GRID, Handle, find_handle
from roomkin.stages.articulated.model import RobotModel, transform_mesh
from roomkin.stages.articulated.urdf_tree import THIN

# VHACD's: 32 pieces show the handle of a drawer with its box and keep a gripper's clearance; one thread, so that the
# same mesh gives the same pieces.
CUT = {"maxConvexHulls": 32, "resolution": 100_000, "maxNumVerticesPerCH": 32, "asyncACD": False}


def with_solid_handles(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (z up, front towards +x, with part types), every handle that is seen as solid as it looks; a line for
    each door or drawer whose collision shape hid its handle or lacked it, so that it was cut anew.

    Grasps are planned on what collides. A hull around a panel with its handle is a blunt wedge, and files often give
    a box for a door.
    """
    frames, links, lines = link_frames(robot), dict(robot.links), []
    for joint in robot.joints:
        if joint.type == "fixed" or joint.part_type is None or joint.handle == "face":
            continue
        names = list_moved_links(joint, robot.joints)
        looks = merge_visuals(robot, names, frames)
        solid = [transform_mesh(piece, frames[name]) for name in names for piece in links[name].collisions]
        if looks is None or not solid:
            continue
        whole: Trimesh = trimesh.util.concatenate(solid)  # type: ignore[assignment]
        if _are_alike(find_handle(looks), find_handle(whole)):
            continue
        for name in names:
            links[name] = replace(links[name], collisions=cut([visual.mesh for visual in links[name].visuals]))
        lines.append(f"{joint.part_type} '{joint.name}': what collides hid its handle: cut anew from what is seen")
    return replace(robot, links=links), lines


def cut(meshes: list[Trimesh]) -> list[Trimesh]:
    """Convex decomposition of some meshes (V-HACD)."""
    whole = trimesh.util.concatenate([Trimesh(mesh.vertices, mesh.faces, process=True) for mesh in meshes])
    pieces = trimesh.decomposition.convex_decomposition(whole, **CUT)
    return [Trimesh(**piece).convex_hull for piece in pieces if np.ptp(piece["vertices"], axis=0).min() > THIN]


def _are_alike(seen: Handle | None, solid: Handle | None) -> bool:
    """Whether the handle of the collision shape is where the visual one is."""
    if seen is None:
        return True
    if solid is None:
        return False
    off = [*(seen.position - solid.position), seen.width - solid.width, seen.protrusion - solid.protrusion]
    return bool(np.abs(off).max() < 3 * GRID)  # as far as rays tell
