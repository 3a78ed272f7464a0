"""Physics checks of imported doors and drawers: links that touch when closed, joints that stick."""

from pathlib import Path

import numpy as np
import sapien
from sapien.physx import PhysxArticulation

from roomkin.stages.articulated.asset_folder import read_asset
from roomkin.stages.contracts.library import Joint
from roomkin.stages.simulation.loading import load_asset, physics_scene

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
