"""Whether things stand: their boxes in MuJoCo, under gravity for two seconds.

What is in something else as it is put (a pillow in the box of a bed, a chair under its table) does not touch it; what
carries a thing carries it at the height at which the thing stands, on all of its ground plan.
"""

from collections.abc import Sequence
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.scorecard.carrying import ON
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import yaw_quaternion

SECONDS, STEP = 2.0, 0.004
TOUCH = 0.002  # metres that boxes may be in each other and still be apart
DENSITY = 200.0  # kg / m^3 of a box of furniture; chosen
PLATE = 0.01  # metres, half the thickness of what carries at another height than its top


def find_standing(
    boxes: Sequence[UprightBox], supports: Sequence[str], overlaps: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which things (N,) stay where they are put: no more than 5 cm and 10 degrees off.

    Args:
        boxes: of the things, in the world.
        supports: what carries each: floor, wall, the place of another, or empty. What hangs on a wall is fixed.
        overlaps: (N, N) of `find_inside`.
    """
    if not boxes:
        return np.zeros(0, dtype=bool)
    import mujoco

    text = ET.tostring(_write_world(boxes, supports, overlaps), encoding="unicode")
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


def _write_world(boxes: Sequence[UprightBox], supports: Sequence[str], overlaps: NDArray[np.float64]) -> ET.Element:
    """MJCF of the floor and the boxes; only pairs that are named touch."""
    root = ET.Element("mujoco")
    ET.SubElement(root, "option", timestep=str(STEP), integrator="implicitfast")
    ET.SubElement(root, "size", memory="64M")
    world, contact = ET.SubElement(root, "worldbody"), ET.SubElement(root, "contact")
    none = {"contype": "0", "conaffinity": "0"}
    ET.SubElement(world, "geom", none, name="floor", type="plane", size="50 50 1")
    bodies = []
    for place, box in enumerate(boxes):
        pose = {"pos": _text(box.center), "quat": _text(yaw_quaternion(box.yaw))}
        body = ET.SubElement(world, "body", pose, name=f"thing_{place}")
        if supports[place] != "wall":
            ET.SubElement(body, "freejoint")
        size = np.maximum(box.size / 2, 1e-3)
        ET.SubElement(body, "geom", none, name=f"{place}", type="box", size=_text(size), density=str(DENSITY))
        if box.bottom > -ON:  # else it is pushed out of the floor, and has not stood
            _touch(contact, "floor", f"{place}")
        bodies.append(body)
    for i, box in enumerate(boxes):
        for j in range(i):
            if overlaps[i, j] <= TOUCH:
                _touch(contact, f"{j}", f"{i}")
        carrier = boxes[int(supports[i])] if supports[i].isdigit() else None
        if carrier is None or overlaps[i, int(supports[i])] <= TOUCH or box.bottom < carrier.bottom:
            continue
        height = min(box.bottom - PLATE, carrier.top) - carrier.center[2]
        plate = [*(np.maximum(carrier.size[:2] / 2, 1e-3)), PLATE]
        massless = none | {"mass": "0"}
        ET.SubElement(bodies[int(supports[i])], "geom", massless, name=f"under_{i}", type="box",
                      pos=_text([0, 0, height]), size=_text(plate))  # fmt: skip
        _touch(contact, f"under_{i}", f"{i}")
    return root


def _touch(contact: ET.Element, one: str, other: str) -> None:
    ET.SubElement(contact, "pair", geom1=one, geom2=other, condim="3", friction="0.8 0.8 0.005 0.0001 0.0001")


def _text(values: Sequence[float] | NDArray[np.float64]) -> str:
    return " ".join(f"{value:.6g}" for value in np.asarray(values, dtype=float))
