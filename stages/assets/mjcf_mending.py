"""MJCF that MuJoCo does not take as it is: what a model can do without is left out, and said."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from stages.contracts.errors import InputError

TRIES = 20  # kinds of faults in one file
# For bodies whose geoms are of none of the groups that count, as of older simulations.
WEIGHED = {"inertiagrouprange": "0 5", "boundmass": "1e-6", "boundinertia": "1e-9"}


def compile_mended(root: ET.Element, path: Path, pictures: dict[str, bytes]) -> tuple[Any, Any, list[str]]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of an MJCF tree, and what was left out, in lines.

    Args:
        root: of the tree; it is changed.
        path: of the file, for complaints.
        pictures: textures by the names that their elements give.

    Raises:
        InputError: MuJoCo refuses it all the same.
    """
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # else it writes MUJOCO_LOG.TXT where the user is
    remarks = _joints_put_right(root)
    for _ in range(TRIES):
        try:
            spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"), assets=pictures)
            return spec, spec.compile(), list(dict.fromkeys(remarks))
        except Exception as error:  # of MuJoCo's own kinds, by version
            reason = " ".join(str(error).split())[:200]
            mended = _mended(root, reason)
            if mended is None:
                raise InputError(path, f"MuJoCo does not take it: {reason}") from None
            remarks.append(mended)
    raise InputError(path, f"MuJoCo does not take it: {reason}")


def _joints_put_right(root: ET.Element) -> list[str]:
    """Turn limits round that are upside down; fix what has a range or an axis of nothing."""
    remarks = []
    for parent in list(root.iter()):
        for joint in parent.findall("joint"):
            limits, axis = _numbers(joint.get("range", "")), _numbers(joint.get("axis", ""))
            named = f"joint '{joint.get('name', '')}'"
            if (axis and not any(axis)) or (len(limits) == 2 and limits[0] == limits[1] != 0):
                parent.remove(joint)
                remarks.append(f"{named}: {'has no range' if any(axis or [1]) else 'its axis is zero'}. It is fixed.")
            elif len(limits) == 2 and limits[0] > limits[1]:
                joint.set("range", " ".join(reversed(joint.get("range", "").split())))
                told = f"{limits[0]:g}, {limits[1]:g}"
                remarks.append(f"{named}: limits upside down ({told}), taken the other way round")
    return remarks


def _numbers(text: str) -> list[float]:
    """The numbers of an attribute; none if one is none, which MuJoCo says."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


def _mended(root: ET.Element, reason: str) -> str | None:
    """Change the tree so that MuJoCo no longer refuses it for a reason; what was done, None: there is nothing to do."""
    if "mjMINVAL" in reason and not any("boundmass" in compiler.attrib for compiler in root.iter("compiler")):
        ET.SubElement(root, "compiler", WEIGHED)
        return "bodies without a mass are weighed by all that they show"
    if found := re.search(r"unrecognized element Element '([^']+)'", reason):
        removed = _removed(root, list(root.iter(found[1])))
        return f"left out: <{found[1]}>, which MuJoCo does not know" if removed else None
    if found := re.search(r"repeated name '([^']*)' in (\w+)", reason):
        name, tag = found.groups()
        same = [e for assets in root.iter("asset") for e in assets.iter(tag) if e.get("name") == name]
        return f"left out: another {tag} '{name}'" if _removed(root, same[1:]) else None
    if found := re.search(r"unrecognized attribute: '([^']+)' Element '([^']+)'", reason):
        key, tag = found.groups()
        stripped = _stripped([e for e in root.iter(tag) if key in e.attrib], key)
        return f"left out: {key} of <{tag}>, which MuJoCo does not know" if stripped else None
    if "required attribute missing" in reason and "Element 'inertial'" in reason:
        removed = _removed(root, [e for e in root.iter("inertial") if not {"pos", "mass"} <= e.attrib.keys()])
        return "left out: an <inertial> that does not say where or how heavy" if removed else None
    if "invalid keyword: 'fixed' Element 'joint'" in reason:
        removed = _removed(root, [e for e in root.iter("joint") if e.get("type") == "fixed"])
        return "left out: joints called fixed" if removed else None
    if found := re.search(r"material '([^']*)' not found", reason):
        stripped = _stripped([e for e in root.iter() if e.get("material") == found[1]], "material")
        return f"grey in place of material '{found[1]}', which is not there" if stripped else None
    return None


def _removed(root: ET.Element, elements: list[ET.Element]) -> bool:
    """Remove elements; whether there are any."""
    for parent in list(root.iter()):
        for child in [child for child in parent if child in elements]:
            parent.remove(child)
    return bool(elements)


def _stripped(elements: list[ET.Element], key: str) -> bool:
    """Remove an attribute of elements; whether there are any."""
    for element in elements:
        del element.attrib[key]
    return bool(elements)
