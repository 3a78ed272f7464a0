"""What is mended of a user's model: masses, hulls that close a handle's gap; and how its joints move then."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import sapien
import trimesh
from sapien.physx import PhysxArticulation
from trimesh import Trimesh

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.articulated.handle import GRID, Handle, find_handle, list_moved_links, merge_visuals
from roomkin.stages.articulated.model import Link, RobotModel, link_frames, measure_closed_box, transform_mesh
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.contracts.library import Joint
from roomkin.stages.geometry.solids import board_mass, box_inertia
from roomkin.stages.simulation.loading import load_asset, physics_scene

HEAVY = 5.0  # times what boards weigh: a door is no solid block, and the water in its hull is ten times as heavy
LIGHTEST, HEAVIEST = 1 / 15, 20.0  # times what boards weigh, of a whole thing: thin sheets, and solid stone or steel
SPARSEST = 4.0  # kg per cubic metre of its box: a chair has fifteen
ROOM = 4.0  # metres: no thing in a room is as wide and as deep
SLACK = 0.01  # by which a principal moment of inertia may exceed the sum of the others


def repair_inertias(robot: RobotModel) -> tuple[RobotModel, list[str]]:
    """The model (in metres) with masses of doors and drawers, and inertias, that its shape can have; lines say what was
    changed, and what is doubtful about the whole."""
    lines, links = _doubts(robot), dict(robot.links)
    for joint in robot.joints:
        if joint.type == "fixed":
            continue
        moving = {name: links[name] for name in list_moved_links(joint, robot.joints)}
        boards = {name: _boards(link) for name, link in moving.items()}
        given, expected = sum(link.mass for link in moving.values()), sum(boards.values())
        if given > HEAVY * expected:
            taken = f"in its file: taken for boards, {expected:.2g} kg"
            lines.append(f"what '{joint.name}' moves weighs {given:.3g} kg {taken}")
            links |= {name: _set_mass(link, boards[name]) for name, link in moving.items()}
    impossible = [name for name, link in links.items() if _is_impossible(link)]
    for name in impossible:
        links[name] = replace(links[name], inertia=box_inertia(links[name].collisions, links[name].mass))
    if impossible:
        names = ", ".join(f"'{name}'" for name in impossible)
        lines.append(f"inertia of {names} taken for that of a box: nothing has the one in its file")
    return replace(robot, links=links), lines


def _doubts(robot: RobotModel) -> list[str]:
    """Lines if it is as large as a room, or if its file says that it weighs what nothing of its size does."""
    extents = np.ptp(measure_closed_box(robot), axis=0)
    shorter, longer = np.sort(extents[:2])
    lines = [f"is {shorter:.2g} by {longer:.2g} m: a whole room is no model (one file a thing)"] * bool(shorter > ROOM)
    weighed = [link for link in robot.links.values() if link.weighed]
    mass, boards = sum(link.mass for link in weighed), sum(_boards(link) for link in weighed)
    if weighed and not LIGHTEST * boards <= mass <= HEAVIEST * boards:
        lines.append(f"weighs {mass:.3g} kg in its file, boards of its size {boards:.3g} kg (asset.json: mass)")
    elif robot.mass < SPARSEST * np.prod(extents):
        lines.append(f"weighs {robot.mass:.3g} kg, less than anything of its size (asset.json: mass)")
    return lines


def _boards(link: Link) -> float:
    return board_mass(link.collisions, link.visuals)


def _set_mass(link: Link, mass: float) -> Link:
    return replace(link, mass=mass, inertia=link.inertia * (mass / link.mass), weighed=False)


def _is_impossible(link: Link) -> bool:
    """Whether nothing has such an inertia: two principal moments are together at least as large as the third."""
    least, middle, most = np.linalg.eigvalsh(link.inertia)
    return bool(most > (1 + SLACK) * (least + middle))


def with_mass(robot: RobotModel, mass: float) -> RobotModel:
    """The model with another total mass, spread as before."""
    ratio = mass / robot.mass
    links = {n: replace(link, mass=link.mass * ratio, inertia=link.inertia * ratio) for n, link in robot.links.items()}
    return replace(robot, links=links)


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


TOUCH = 0.002  # metres: parts that are as near when closed would rub
MOST_PAIRS = 31  # that SAPIEN tells apart
FORCE = 20.0  # N at a drawer, or at a door's free edge: less than a gripper pulls with
SECONDS = 20.0  # for how long at most
OPEN = 0.9  # of its range, for a joint that does not stick
CREEPS = 0.01  # of its range in the last tenth of the time: what goes on by more is slow (a heavy door), and not stuck


def find_touching_links(folder: Path) -> tuple[tuple[str, str], ...]:
    """Pairs of links of an asset that touch when everything is closed, by name; a link and its parent never collide.

    Raises:
        InputError: the simulator does not take the asset.
    """
    body = _load_asset(folder, timestep=1e-5)
    if body is None:
        return ()
    scene, _ = body
    scene.step()
    pairs = set()
    for contact in scene.get_contacts():
        if any(point.separation < TOUCH for point in contact.points):
            one, other = sorted(component.entity.name for component in contact.bodies)
            pairs.add((one, other))
    return tuple(sorted(pairs)[:MOST_PAIRS])


def stuck_joints(folder: Path) -> list[str]:
    """A line for every door or drawer that a steady push does not open."""
    body = _load_asset(folder) if read_asset(folder).joints else None
    if body is None:
        return []
    scene, articulation = body
    closed = articulation.get_qpos().copy()
    known = {joint.name: joint for joint in read_asset(folder).joints}
    lines = []
    for number, joint in enumerate(articulation.get_active_joints()):
        if joint.name not in known:
            continue
        articulation.set_qpos(closed)
        articulation.set_qvel(np.zeros_like(closed))
        push = np.zeros_like(closed)
        push[number] = FORCE * _lever(known[joint.name])
        low, high = joint.limits[0].tolist()
        farthest, steps, before = low, round(SECONDS / scene.timestep), low
        for step in range(steps):
            if step == round(0.9 * steps):
                before = farthest
            articulation.set_qf(push + articulation.compute_passive_force(True, True))
            scene.step()
            farthest = max(farthest, float(articulation.get_qpos()[number]))
            if farthest > low + OPEN * (high - low):
                break
        share = (farthest - low) / (high - low)
        if share <= OPEN and farthest - before < CREEPS * (high - low):
            lines.append(f"{known[joint.name].part_type} '{joint.name}' sticks at {100 * share:.0f} % of its range")
    return lines


def _lever(joint: Joint) -> float:
    """Metres between the axis and where it is pushed; 1 for what slides."""
    if joint.type == "prismatic" or joint.panel is None:
        return 1.0
    width, height = joint.panel.size
    return height if joint.panel.hinge in ("bottom", "top") else width


def _load_asset(folder: Path, **options: float) -> tuple[sapien.Scene, PhysxArticulation] | None:
    """The asset alone in a scene, fixed and closed; None if nothing of it moves."""
    scene = physics_scene(**options)
    body = load_asset(scene, folder, sapien.Pose(), fixed=True, name="imported")
    return (scene, body) if read_asset(folder).joints and isinstance(body, PhysxArticulation) else None
