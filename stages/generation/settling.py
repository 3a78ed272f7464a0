"""The physics check: put the scene into SAPIEN, let it settle, and see what moves (CPU PhysX); nothing is rendered."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien.physx import PhysxArticulation
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.urdf_writer import write_urdf
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.generated import Plausibility
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.contracts.types import UNNAMED
from roomkin.stages.generation.placed import Placed
from roomkin.stages.geometry.boxes import depth_behind, is_behind
from roomkin.stages.simulation.loading import box_center, load_asset, physics_scene, root_pose
from roomkin.stages.simulation.room import Body, add_backdrop

OVERLAP = 0.005  # metres that push things: 5 mm threw light things over (GenerationConfig.touch)


@dataclass(frozen=True)
class Settled:
    """The verdict, and how far every item moved, metres."""

    plausibility: Plausibility
    shifts: dict[str, float]


def simulate(items: list[Placed], room: Objects, collisions: int, options: GenerationConfig) -> Settled:
    """Let a scene settle with floor and walls. `collisions`: pairs that the pushes could not free."""
    scene = physics_scene()
    add_backdrop(scene, [item.box for item in items], room.walls, np.array(room.floor_from_camera)[:3, 3])
    return run_physics(scene, load_items(scene, items), items, collisions, options, room.walls)


def load_items(scene: sapien.Scene, items: Sequence[Placed]) -> dict[str, Body]:
    """Load every item at its place, closed. The simulator reads URDFs: a model at another size is written for it."""
    with TemporaryDirectory(prefix="acdc-sized-") as out:
        folders = [item.folder if item.robot is None else write_urdf(item.robot, Path(out) / item.id) for item in items]
        poses = [root_pose(item.asset, item.center.tolist(), item.box.yaw) for item in items]
        return {
            item.id: load_asset(scene, folder, pose, item.held, item.id, asset=item.asset)
            for item, folder, pose in zip(items, folders, poses, strict=True)
        }


def run_physics(
    scene: sapien.Scene,
    bodies: Mapping[str, Body],
    items: list[Placed],
    collisions: int,
    options: GenerationConfig,
    walls: Sequence[Wall] = (),
) -> Settled:
    """Run the scene for `settle_seconds` and compare where everything is with where it was put.

    Args:
        scene: holds the bodies of `load_items`, a floor and the walls.
        collisions: pairs of collision shapes that the pushes could not free.
        walls: a scene is not stable if something reaches behind one that does not end before it.
    """
    steps = round(options.settle_seconds / scene.timestep)
    penetration, overlaps = 0.0, {}
    for step in range(steps):
        scene.step()
        if step == 0:
            penetration, overlaps = deepest_contact(scene), find_overlaps(scene, bodies)
    shifts: dict[str, float] = {}
    how: dict[str, str] = {}
    for item in items:
        body = bodies[item.id]
        pose = body.get_root_pose() if isinstance(body, PhysxArticulation) else body.get_pose()
        shift = (pose * sapien.Pose(box_center(item.asset))).p - item.center
        shifts[item.id] = round(float(np.linalg.norm(shift)), 5)
        if np.linalg.norm(shift) > options.fallen_distance or _tilt(pose) > options.fallen_tilt:
            how[item.id] = describe_fall(shift, _tilt(pose), overlaps.get(item.id, ""), options)
    free = [shifts[item.id] for item in items if not item.held]
    held = [item.id for item in items if item.support == UNNAMED]
    in_walls = find_behind(items, walls)
    verdict = Plausibility(
        seconds=options.settle_seconds, stable=not (how or collisions or held or in_walls), fallen=list(how), how=how,
        held=held, behind=in_walls, mean_displacement=round(float(np.mean(free)), 5) if free else 0.0,
        max_penetration=round(penetration, 5), collisions=collisions,
    )  # fmt: skip
    return Settled(verdict, shifts)


def describe_fall(shift: NDArray[np.float64], tilt: float, overlapped: str, options: GenerationConfig) -> str:
    """The motion of an item that did not stay.

    Args:
        shift: (3,) of its middle, metres.
        tilt: degrees.
        overlapped: what it overlapped most before it moved; empty: nothing.
    """
    if tilt > options.fallen_tilt:
        what = f"tipped by {tilt:.0f}°"
    elif -shift[2] > np.linalg.norm(shift[:2]):
        what = f"dropped {-100 * shift[2]:.0f} cm"
    else:
        what = f"{'was pushed' if overlapped else 'slid'} {100 * np.linalg.norm(shift):.0f} cm"
    return f"{what}, for it overlapped {overlapped}" if overlapped else what


def find_overlaps(scene: sapien.Scene, bodies: Mapping[str, Body]) -> dict[str, str]:
    """Items that overlap floor, wall or another item by more than `OVERLAP`, with that which they overlap most."""
    names = {
        part.entity.per_scene_id if isinstance(body, PhysxArticulation) else body.per_scene_id: name
        for name, body in bodies.items()
        for part in (body.links if isinstance(body, PhysxArticulation) else [body])
    }
    deepest: dict[str, tuple[float, str]] = {}
    for contact in scene.get_contacts():
        one, other = (names.get(part.entity.per_scene_id, part.entity.name) for part in contact.bodies)
        depth = -min((point.separation for point in contact.points), default=0.0)
        for name, what in ((one, other), (other, one)):
            if name != what and depth > max(OVERLAP, deepest.get(name, (0.0, ""))[0]):
                deepest[name] = depth, what
    return {name: what for name, (_, what) in deepest.items() if name in bodies}


def find_behind(items: Sequence[Placed], walls: Sequence[Wall]) -> list[str]:
    """Ids of items that reach into a wall. An item wholly behind its plane is seen past the wall's end and does not
    count."""
    return [
        item.id
        for item in items
        if any(
            depth_behind(item.box, wall.normal, wall.offset) > DoubtKind.BEHIND_WALL.threshold
            and not is_behind(item.box, wall.normal, wall.offset)
            for wall in walls
        )
    ]


def deepest_contact(scene: sapien.Scene) -> float:
    """Largest overlap of any two bodies in contact, metres."""
    separations = [point.separation for contact in scene.get_contacts() for point in contact.points]
    return max(0.0, -min(separations, default=0.0))


def _tilt(pose: sapien.Pose) -> float:
    """Angle between the body's z axis and the world's, degrees."""
    up = Rotation.from_quat(pose.q, scalar_first=True).as_matrix()[2, 2]
    return float(np.degrees(np.arccos(np.clip(up, -1, 1))))
