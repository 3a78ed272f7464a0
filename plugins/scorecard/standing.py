"""Whether things stand: in MuJoCo, under gravity for two seconds; and how deep they are in each other there.

A thing is its convex pieces, where it has some, else its box.

What is in something else as it is put (a pillow in the box of a bed, a chair under its table) does not touch it; what
carries a thing carries it at the height at which the thing stands, on all of its ground plan.
"""

from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as ET

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.plugins.scorecard.carrying import ON
from roomkin.plugins.scorecard.solids import Floats
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import yaw_quaternion

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
