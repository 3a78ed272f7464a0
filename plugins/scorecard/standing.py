"""What carries what, and whether it stands: in MuJoCo, under gravity for two seconds, by boxes or convex pieces."""

from collections.abc import Collection, Mapping, Sequence
from xml.etree import ElementTree as ET

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.plugins.scorecard.truth import Cells, SubmittedThing, TrueThing
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.evaluation.scoring import DENSE, fill_cells
from roomkin.stages.geometry.boxes import UprightBox, corners, footprint
from roomkin.stages.geometry.frames import yaw_quaternion

ON, AT_WALL = 0.05, 0.10  # metres between a thing and what carries it, and the wall that it hangs on
INSIDE = 0.02  # metres by which things may be in each other more than the true ones are
BELOW = 0.05  # metres by which a box may be under the floor


def find_support(place: int, boxes: Sequence[UprightBox], room: tuple[float, float]) -> str:
    """What carries a thing that does not say so: floor, wall, the place of another, or nothing.

    Args:
        place: of the thing in the list.
        boxes: all things, in the world.
        room: extents of the floor along x and y, metres.
    """
    box = boxes[place]
    under, best = footprint(box), (0.0, "")
    for other, carrier in enumerate(boxes):
        reaches = carrier.bottom < box.bottom - ON and carrier.top > box.bottom - ON
        share = under.intersection(footprint(carrier)).area if other != place and reaches else 0.0
        best = max(best, (share, str(other)))
    if box.bottom <= ON:
        return "floor"
    if best[0] > 0.3 * under.area:
        return best[1]
    points = corners(box)[:, :2]
    gap = min((np.array(room) - points).min(), points.min())
    return "wall" if gap < AT_WALL else ""


def list_supports(
    things: Sequence[SubmittedThing], boxes: Sequence[UprightBox], room: tuple[float, float]
) -> list[str]:
    """What carries every thing: as it says, else as its box tells."""
    return [thing.support or find_support(place, boxes, room) for place, thing in enumerate(things)]


def is_carrier_right(thing: TrueThing, support: str, pairs: Mapping[int, int], asked: Sequence[int]) -> bool | None:
    """Whether a thing is carried by what truly carries it; None: that is nothing that was asked for."""
    if thing.support in ("floor", "wall"):
        return support == thing.support
    true = int(thing.support)
    return true in pairs and support == str(pairs[true]) if true in asked else None


def measure_overlap(one: UprightBox, other: UprightBox) -> float:
    """The least shift that parts two upright boxes, metres; 0: they are apart."""
    up = min(one.top, other.top) - max(one.bottom, other.bottom)
    if up <= 0:
        return 0.0
    a, b = corners(one)[:4, :2], corners(other)[:4, :2]
    least = up
    for yaw in (one.yaw, one.yaw + np.pi / 2, other.yaw, other.yaw + np.pi / 2):
        axis = np.array([np.cos(yaw), np.sin(yaw)])
        p, q = a @ axis, b @ axis
        least = min(least, min(p.max(), q.max()) - max(p.min(), q.min()))
    return float(max(least, 0.0))


def find_inside(
    boxes: Sequence[UprightBox],
    truth: Mapping[int, UprightBox],
    depths: NDArray[np.float64] | None = None,
    pieces: Collection[int] = (),
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Overlaps (N, N) of things, metres, and which things are in something (N,).

    A chair under its table and a pillow on a bed are in each other's boxes in truth: a pair of which one is a box
    counts by what it is more. Meshes are in nothing in truth.

    Args:
        boxes: submitted, in the world.
        truth: box of the true thing by place of the submitted one, of those that stand for one.
        depths: (N, N) of `measure_depths`, for pairs of which one at least has a shape.
        pieces: places of those that have one.
    """
    overlaps = np.zeros((len(boxes), len(boxes)))
    inside = np.array([box.bottom < -BELOW for box in boxes], dtype=bool)
    for i in range(len(boxes)):
        for j in range(i):
            shaped = (i in pieces) + (j in pieces)
            depth = measure_overlap(boxes[i], boxes[j]) if depths is None or not shaped else depths[i, j]
            overlaps[i, j] = overlaps[j, i] = depth
            right = measure_overlap(truth[i], truth[j]) if i in truth and j in truth and shaped < 2 else 0.0
            if overlaps[i, j] > right + INSIDE:
                inside[[i, j]] = True
    return overlaps, inside


Floats = NDArray[np.float64]
# V-HACD's: half a second a thing; one thread, so that the same surface gives the same pieces.
CUT = {"maxConvexHulls": 16, "resolution": 30_000, "maxNumVerticesPerCH": 32, "asyncACD": False}
THIN = 1e-4  # metres: what is thinner has no volume
SLACK = 0.02  # metres by which pieces may miss an end of the surface


def cut_solid(surface: trimesh.Trimesh, box: UprightBox) -> list[Floats]:
    """Corners (N, 3) of convex pieces of a thing, in the frame of its box; none: it has no volume that can be cut.

    Args:
        surface: of the thing, as it was submitted.
        box: in the world, which may be the larger or the smaller by one factor.
    """
    whole = trimesh.Trimesh(surface.vertices * (box.size / np.maximum(surface.extents, THIN)), surface.faces)
    try:
        pieces = trimesh.decomposition.convex_decomposition(whole, **CUT)
    except Exception:  # a library's, on a surface from elsewhere: its box stands for it
        return []
    hulls = [np.asarray(piece["vertices"], dtype=float) for piece in pieces]
    hulls = [hull for hull in hulls if len(hull) > 3 and _is_thick(hull)]
    ends = np.concatenate(hulls) if hulls else np.zeros((1, 3))
    covers = np.abs(np.stack([ends.min(axis=0), ends.max(axis=0)]) - whole.bounds).max() <= SLACK
    return hulls if covers else []


def _is_thick(hull: Floats) -> bool:
    """Whether no direction is thinner than `THIN`."""
    return bool(np.linalg.svd(hull - hull.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(hull)) > THIN)


def cut_solids(solids: Mapping[int, trimesh.Trimesh], boxes: Sequence[UprightBox]) -> dict[int, list[Floats]]:
    """Convex pieces by place in the list, of the things that have some."""
    cut = {place: cut_solid(solid, boxes[place]) for place, solid in solids.items()}
    return {place: pieces for place, pieces in cut.items() if pieces}


def fill_solid(surface: trimesh.Trimesh) -> Cells:
    """What is filled of a thing's box, along its own axes."""
    points = np.asarray(trimesh.sample.sample_surface(surface, DENSE, seed=0)[0])
    low, high = surface.bounds
    return fill_cells((points - low) / np.maximum(high - low, 1e-9))


SECONDS, STEP = 2.0, 0.004
TOUCH = 0.002  # metres that boxes may be in each other and still be apart
DENSITY = 200.0  # kg / m^3 of a box of furniture; chosen
FRICTION = "0.8 0.005 0.0001"
PLATE = 0.01  # metres, half the thickness of what carries at another height than its top


def measure_depths(boxes: Sequence[UprightBox], pieces: Mapping[int, list[Floats]]) -> Floats:
    """How deep (N, N) things are in each other, metres, of pairs of which one at least has pieces.

    Args:
        boxes: of the things, in the world.
        pieces: corners (N, 3) of convex pieces in the frame of a thing's box, by place in the list.
    """
    depths = np.zeros((len(boxes), len(boxes)))
    if not pieces:
        return depths
    import mujoco

    root, _ = _write_things(boxes, ["" for _ in boxes], pieces)
    world = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    data = mujoco.MjData(world)
    mujoco.mj_kinematics(world, data)
    mujoco.mj_collision(world, data)
    for geoms, apart in zip(data.contact.geom, data.contact.dist, strict=True):
        i, j = world.geom_bodyid[geoms] - 1
        if i in pieces or j in pieces:
            depths[i, j] = depths[j, i] = max(depths[i, j], -apart)
    return depths


def find_standing(
    boxes: Sequence[UprightBox],
    supports: Sequence[str],
    overlaps: Floats,
    pieces: Mapping[int, list[Floats]] | None = None,
) -> NDArray[np.bool_]:
    """Which things (N,) stay where they are put: no more than 5 cm and 10 degrees off.

    Args:
        boxes: of the things, in the world.
        supports: what carries each: floor, wall, the place of another, or empty. What hangs on a wall is fixed.
        overlaps: (N, N) of `find_inside`.
        pieces: of `measure_depths`.
    """
    if not boxes:
        return np.zeros(0, dtype=bool)
    import mujoco

    text = ET.tostring(_write_world(boxes, supports, overlaps, pieces or {}), encoding="unicode")
    world = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(world)
    mujoco.mj_forward(world, data)
    before, turned = data.xpos[1:].copy(), data.xmat[1:].reshape(-1, 3, 3)[:, :, 2].copy()
    mujoco.mj_step(world, data, nstep=round(SECONDS / STEP))
    mujoco.mj_kinematics(world, data)
    moved = np.linalg.norm(data.xpos[1:] - before, axis=1)
    cosine = (data.xmat[1:].reshape(-1, 3, 3)[:, :, 2] * turned).sum(axis=1)
    tilt = np.rad2deg(np.arccos(np.clip(cosine, -1, 1)))
    fit = (moved <= GenerationConfig.fallen_distance) & (tilt <= GenerationConfig.fallen_tilt)
    return np.asarray(fit & np.isfinite(moved))


def _write_world(
    boxes: Sequence[UprightBox], supports: Sequence[str], overlaps: Floats, pieces: Mapping[int, list[Floats]]
) -> ET.Element:
    """MJCF of the floor and the things; what is in another, or below the floor, does not touch it."""
    root, bodies = _write_things(boxes, supports, pieces)
    world, contact = root.find("worldbody"), ET.SubElement(root, "contact")
    assert world is not None
    ET.SubElement(world, "geom", name="floor", type="plane", size="50 50 1", friction=FRICTION)
    for i, box in enumerate(boxes):
        if box.bottom <= -ON:  # else it is pushed out of the floor, and has not stood
            ET.SubElement(contact, "exclude", body1="world", body2=f"thing_{i}")
        for j in range(i):
            if overlaps[i, j] > TOUCH:
                ET.SubElement(contact, "exclude", body1=f"thing_{j}", body2=f"thing_{i}")
        carrier = boxes[int(supports[i])] if supports[i].isdigit() else None
        if carrier is None or overlaps[i, int(supports[i])] <= TOUCH or box.bottom < carrier.bottom:
            continue
        height = min(box.bottom - PLATE, carrier.top) - carrier.center[2]
        plate = [*(np.maximum(carrier.size[:2] / 2, 1e-3)), PLATE]
        under = {"mass": "0", "contype": "0", "conaffinity": "0"}
        ET.SubElement(bodies[int(supports[i])], "geom", under, name=f"under_{i}", type="box",
                      pos=_text([0, 0, height]), size=_text(plate))  # fmt: skip
        for geom in bodies[i].iter("geom"):
            if geom.get("name", "").startswith(f"{i}/"):
                ET.SubElement(contact, "pair", geom1=f"under_{i}", geom2=geom.attrib["name"], condim="3",
                              friction="0.8 0.8 0.005 0.0001 0.0001")  # fmt: skip
    return root


def _write_things(
    boxes: Sequence[UprightBox], supports: Sequence[str], pieces: Mapping[int, list[Floats]]
) -> tuple[ET.Element, list[ET.Element]]:
    """MJCF of the things alone, and the body of each; what hangs on a wall is fixed."""
    root = ET.Element("mujoco")
    ET.SubElement(root, "option", timestep=str(STEP), integrator="implicitfast")
    ET.SubElement(root, "size", memory="256M")
    asset, world, bodies = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody"), []
    for place, box in enumerate(boxes):
        pose = {"pos": _text(box.center), "quat": _text(yaw_quaternion(box.yaw))}
        body = ET.SubElement(world, "body", pose, name=f"thing_{place}")
        if supports[place] != "wall":
            ET.SubElement(body, "freejoint")
        size, hulls = np.maximum(box.size / 2, 1e-3), pieces.get(place, [])
        mass = DENSITY * float(np.prod(2 * size))
        for number, hull in enumerate(hulls):
            name = f"{place}/{number}"
            ET.SubElement(asset, "mesh", name=name, vertex=_text(hull.ravel()), inertia="shell")
            ET.SubElement(body, "geom", name=name, type="mesh", mesh=name, friction=FRICTION)
        if hulls:
            solid = [trimesh.convex.convex_hull(hull) for hull in hulls]
            shares = np.array([one.volume for one in solid])
            middle = np.average([one.center_mass for one in solid], axis=0, weights=shares)
            inertia = mass / 12 * ((size * 2) ** 2 @ (1 - np.eye(3)))
            ET.SubElement(body, "inertial", pos=_text(middle), mass=_text([mass]), diaginertia=_text(inertia))
        else:
            ET.SubElement(body, "geom", name=f"{place}/0", type="box", size=_text(size), friction=FRICTION,
                          mass=_text([mass]))  # fmt: skip
        bodies.append(body)
    return root, bodies


def _text(values: Sequence[float] | Floats) -> str:
    return " ".join(f"{value:.6g}" for value in np.asarray(values, dtype=float))
