"""The handle of a door or drawer, found by ray casting (paper A.4); its kind, hinge side, extents of the front."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.stages.articulated.model import JointModel, Matrix, RobotModel, visual_bounds
from roomkin.stages.contracts.library import FrontPanel, HandleKind
from roomkin.stages.contracts.parts import HingeSide

Array = NDArray[np.float64]

GRID = 0.004  # metres between rays
NEAREST = 0.005  # rays that end this close behind the nearest hit make up the mean handle location (official code)
FRONT = 0.015  # the foremost slice that tells the handle's direction and extents
SURFACE_GAP = 0.001  # metres: what is nearer to a surface along a ray belongs to it
PROTRUSION = 0.012  # a handle sticks out at least this far from its panel
WIDEST = 0.07  # across a handle that a gripper of 8 cm closes on


@dataclass(frozen=True)
class Handle:
    """A graspable handle, in the asset frame with all joints closed. The front faces +x; metres.

    position: (3,) center of its foremost surface. axis: (3,) long direction, in the y-z plane.
    protrusion: distance from the panel to the foremost surface. length, width: extents along and across `axis`.
    """

    position: Array
    axis: Array
    protrusion: float
    length: float
    width: float

    @property
    def elongated(self) -> bool:
        """Whether it has a long direction (a bar); a knob has none."""
        return self.length > 2.0 * self.width


def front_hits(mesh: trimesh.Trimesh) -> Array:
    """First hits (N, 3) of rays that fly along -x onto the mesh, on a grid over its y-z extents."""
    low, high = mesh.bounds
    y, z = (np.arange(low[i] + GRID / 2, high[i], GRID) for i in (1, 2))
    origins = np.stack(np.meshgrid([high[0] + 0.1], y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    directions = np.tile([-1.0, 0.0, 0.0], (len(origins), 1))
    hits, _, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    return np.asarray(hits)


def find_handle(mesh: trimesh.Trimesh) -> Handle | None:
    """The most protruding feature of a closed panel, or None if nothing sticks out of it.

    What is wider than a gripper may be the raised frame of a front: then it is what stands on that, or within it.

    Args:
        mesh: the moving link with everything fixed to it, in the asset frame, closed.
    """
    hits = front_hits(mesh)
    if len(hits) < 10:
        return None
    panel = _panel_depth(hits[:, 0])
    handle = _find_protrusion(hits, panel)
    if handle is None or handle.width <= WIDEST + GRID:
        return handle
    frame = _panel_depth(hits[hits[:, 0] > (panel + handle.position[0]) / 2, 0])
    others = _find_protrusion(hits, frame), _find_protrusion(hits[hits[:, 0] < frame - SURFACE_GAP], panel)
    return next((other for other in others if other is not None and other.width <= WIDEST + GRID), handle)


def _find_protrusion(hits: Array, panel: float) -> Handle | None:
    """The most protruding feature of a panel at x = `panel`, from ray hits (N, 3)."""
    if not len(hits):
        return None
    nearest = hits[:, 0].max()
    protrusion = float(nearest - panel)
    if protrusion < PROTRUSION:
        return None
    position = hits[hits[:, 0] > nearest - NEAREST].mean(axis=0)
    front = hits[hits[:, 0] > nearest - min(FRONT, protrusion / 2)][:, 1:]
    _, directions = np.linalg.eigh(np.cov(front.T) + 1e-12 * np.diag([0.0, 1.0]))
    along = directions[:, 1]
    across = np.array([-along[1], along[0]])
    length, width = (float(np.ptp(front @ direction)) + GRID for direction in (along, across))
    return Handle(np.array([nearest, *position[1:]]), np.array([0.0, *along]), protrusion, length, width)


def exact_width(mesh: trimesh.Trimesh, handle: Handle) -> float:
    """Width of a handle in metres, from its mesh: the grid of rays that found it adds up to 4 mm."""
    depth = handle.position[0] - min(FRONT, handle.protrusion / 2)
    part = trimesh.intersections.slice_mesh_plane(mesh, [1.0, 0.0, 0.0], [depth, 0.0, 0.0])
    along = handle.axis[1:]
    across = np.array([-along[1], along[0]])
    points = np.asarray(part.vertices)[:, 1:] - handle.position[1:]
    its_own = (np.abs(points @ across) <= handle.width) & (np.abs(points @ along) <= handle.length)
    return float(np.ptp(points[its_own] @ across)) if its_own.any() else handle.width


def _panel_depth(x: Array) -> float:
    """The x at which most rays end: the panel covers more area than its frame or its handle."""
    counts, edges = np.histogram(x, bins=max(1, int(np.ceil(np.ptp(x) / NEAREST))))
    best = int(counts.argmax())
    return float(np.median(x[(x >= edges[best]) & (x <= edges[best + 1])]))


ROOM = 0.5  # metres before a handle that a hand and its forearm need
AT_EDGE = 0.06  # metres from a side of the panel within which a profile counts as its edge
MOST_OF_IT = 0.7  # share of the panel's extent that such a profile runs along at least
BENT = 0.15  # share of an arch's surface that lies deeper than four fifths of how far it stands out; a bar has less


def front_panel(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix], low: Matrix) -> FrontPanel | None:
    """The front that a joint moves; None if it moves nothing visible (a helper link).

    Args:
        frames: of the links, everything closed.
        low: lowest corner (3,) of the asset's box in the root frame.
    """
    links = list_moved_links(joint, robot.joints)
    boxes = (visual_bounds(robot.links[link].visuals, frames[link]) for link in links)
    corners = [box for box in boxes if box is not None]
    if not corners:
        return None
    least, most = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
    middle = (least + most) / 2  # +y is on the right of someone who looks along -x
    across, height, width, tall = (
        round(float(each), 5) for each in (*(middle - low)[1:], *np.maximum(most - least, 1e-6)[1:])
    )
    side = _hinge_side(joint, frames[joint.child], middle)
    return FrontPanel(hinge=side, across=across, height=height, size=(width, tall))


def measure_handle(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix]) -> HandleKind | None:
    """Kind of the handle on the links that a joint moves, from their shape; None: no handle, see `ungraspable`."""
    held = _find_handle(robot, joint, frames)
    return None if isinstance(held, str) else _kind(*held)


def explain_ungraspable(robot: RobotModel, joint: JointModel, frames: dict[str, Matrix]) -> str | None:
    """The reason why a gripper cannot grasp the links that a joint moves; None: it can."""
    held = _find_handle(robot, joint, frames)
    return held if isinstance(held, str) else None


def _find_handle(
    robot: RobotModel, joint: JointModel, frames: dict[str, Matrix]
) -> tuple[Handle, trimesh.Trimesh] | str:
    """The handle on the links that a joint moves, with their mesh; or the reason why a gripper cannot grasp it."""
    moving = list_moved_links(joint, robot.joints)
    mesh = merge_visuals(robot, moving, frames)
    handle = None if mesh is None else find_handle(mesh)
    if handle is None or mesh is None:
        return f"nothing stands out of its front by {1000 * PROTRUSION:.0f} mm or more"
    if (width := exact_width(mesh, handle)) > WIDEST:
        return f"what stands out of its front is {100 * width:.3g} cm wide, and a gripper holds {100 * WIDEST:.0f}"
    others = merge_visuals(robot, robot.links.keys() - set(moving), frames)
    ahead = np.array([1.0, 0.0, 0.0])
    if others is not None:
        hits, _, _ = others.ray.intersects_location(
            [handle.position + SURFACE_GAP * ahead], [ahead], multiple_hits=False
        )
        if len(hits) and (room := float(hits[0, 0] - handle.position[0])) < ROOM:
            return f"{100 * room:.2g} cm before its handle stands something else"
    return handle, mesh


def merge_visuals(robot: RobotModel, links: Iterable[str], frames: dict[str, Matrix]) -> trimesh.Trimesh | None:
    """Visual meshes of some links as one mesh in the root frame; None: they have none."""
    meshes = [
        trimesh.Trimesh(trimesh.transform_points(visual.mesh.vertices, frames[link]), visual.mesh.faces, process=False)
        for link in links
        for visual in robot.links[link].visuals
    ]
    return trimesh.util.concatenate(meshes) if meshes else None  # type: ignore[return-value]


def list_moved_links(joint: JointModel, joints: Sequence[JointModel]) -> list[str]:
    """The link that a joint moves and all that is fixed to it, such as its handle."""
    links = [joint.child]
    for other in joints:  # parents before children
        if other.type == "fixed" and other.parent in links:
            links.append(other.child)
    return links


def _hinge_side(joint: JointModel, frame: Matrix, middle: Matrix) -> HingeSide:
    """The side of a panel on which the axis of its joint lies; `middle` is the panel's, the front faces +x."""
    if joint.type == "prismatic":
        return "slide"
    across, up = (frame[:3, 3] - middle)[1:]
    upright = np.argmax(np.abs(frame[:3, :3] @ joint.axis)) == 2
    if upright:
        return "right" if across > 0 else "left"  # +y is on the right of someone who looks along -x
    return "top" if up > 0 else "bottom"


def _kind(handle: Handle, panel: trimesh.Trimesh) -> HandleKind:
    if not handle.elongated:
        return "knob"
    along = int(np.argmax(np.abs(handle.axis)))
    across = 3 - along  # of y and z, the other one
    low, high = panel.bounds
    margin = min(handle.position[across] - low[across], high[across] - handle.position[across])
    if margin < AT_EDGE and handle.length > MOST_OF_IT * (high - low)[along]:
        return "edge"
    hits = front_hits(panel)
    near = np.abs(hits[:, across] - handle.position[across]) < max(GRID, handle.width / 4)
    near &= np.abs(hits[:, along] - handle.position[along]) < handle.length / 2
    depth = (hits[near, 0] - handle.position[0]) / handle.protrusion + 1.0  # 0 at the panel, 1 at the foremost surface
    raised = depth > 0.15
    bent = raised & (depth < 0.8)
    return "arch" if bent.sum() > BENT * raised.sum() else "bar"
