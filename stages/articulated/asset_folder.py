"""Asset folders: parts of their joints with handles, a checksum, written whole or not at all."""

import hashlib
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from roomkin.stages.articulated.handle import front_panel, measure_handle
from roomkin.stages.articulated.model import JointModel, RobotModel, link_frames, measure_closed_box
from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.articulated.urdf_writer import write_urdf
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import as_json, ask_before_writing, forget, make_partial_path, read_json, record
from roomkin.stages.contracts.library import Asset, Joint, Placement, Recipe, Symmetry
from roomkin.stages.contracts.parts import FRONTS, PARTS
from roomkin.stages.contracts.system import name_file_in_errors

HANDLE_NAMES = ("handle", "knob", "nob", "pull", "grip")
AGAIN = "make the library again: snakemake --cores 2 library"


def assign_part_types(robot: RobotModel) -> RobotModel:
    """The model with the part type of every moving joint: as its reader says, else the front with such a joint.

    A fixed child whose name says so is the handle; else it is looked for on the moving link itself. A button is pushed
    at its face.
    """
    fixed = {joint.child: joint.parent for joint in robot.joints if joint.type == "fixed"}

    def assign(joint: JointModel) -> JointModel:
        if joint.type == "fixed":
            return joint
        if joint.part_type == "button":
            return replace(joint, handle_link=joint.child, handle="face")
        attached = (child for child, parent in fixed.items() if parent == joint.child)
        named = (child for child in attached if any(word in child.lower() for word in HANDLE_NAMES))
        part = next(front for front in FRONTS if PARTS[front].joint == joint.type)
        return replace(joint, part_type=part, handle_link=next(named, joint.child))

    return replace(robot, joints=[assign(joint) for joint in robot.joints])


def copy_part_types(robot: RobotModel, described: Iterable[Joint]) -> RobotModel:
    """A model with the part types and handles that its `asset.json` gives to its joints, by name."""
    known: dict[str, dict[str, Any]] = {
        one.name: {"part_type": one.part_type, "handle_link": one.handle_link, "handle": one.handle}
        for one in described
    }
    return replace(robot, joints=[replace(joint, **known.get(joint.name, {})) for joint in robot.joints])


def contract_joints(robot: RobotModel) -> list[Joint]:
    """The joints with a part type as the contract names them, with what can be measured of fronts and handles."""
    frames, low = link_frames(robot), measure_closed_box(robot)[0]
    joints = []
    for joint in robot.joints:
        if joint.type == "fixed" or joint.part_type is None:
            continue
        handle = joint.handle
        if handle is None and joint.handle_link is not None:  # stated, without its kind
            handle = measure_handle(robot, joint, frames)
        joints.append(Joint(
            name=joint.name, type=joint.type, part_type=joint.part_type, parent=joint.parent, link=joint.child,
            axis=tuple(joint.axis.round(9).tolist()), lower=round(joint.lower, 5), upper=round(joint.upper, 5),
            handle_link=joint.handle_link if handle else None, handle=handle,
            panel=front_panel(robot, joint, frames, low),
        ))  # fmt: skip
    return joints


@dataclass(frozen=True)
class Description:
    """The fields of `Asset` that geometry does not tell."""

    id: str
    category: str
    licence: str
    provenance: str
    symmetry: Symmetry = "none"
    placement: Placement = "floor"
    recipe: Recipe | None = None


def write_asset(robot: RobotModel, out: Path, about: Description) -> Asset:
    """Write the asset folder `out` of a model (z up, front towards +x); an old one is replaced."""
    low, high = measure_closed_box(robot).round(6) + 0.0
    joints = contract_joints(robot)
    doors, drawers, buttons = (sum(joint.part_type == part for joint in joints) for part in PARTS)
    with atomic_folder(out) as folder:
        write_urdf(robot, folder)
        asset = Asset(
            **vars(about), box_min=tuple(low.tolist()), box_max=tuple(high.tolist()), mass=round(robot.mass, 4),
            joints=joints, doors=doors, drawers=drawers, buttons=buttons, checksum=checksum(folder),
        )  # fmt: skip
        (folder / "asset.json").write_text(as_json(asset), encoding="utf-8")  # the archive it goes into is synced
    return asset


def read_model(folder: Path) -> RobotModel:
    """The model of an asset folder, with the part types that its `asset.json` gives to its joints."""
    asset = read_asset(folder)
    urdf = urdf_of(folder, asset)
    robot = read_urdf(urdf, folder)
    if robot.remarks:  # of what we wrote nothing is missing
        raise InputError(urdf, robot.remarks[0], AGAIN, code="E-ASSET-STALE")
    robot = copy_part_types(robot, asset.joints)
    return replace(robot, touching=read_srdf(urdf.with_suffix(".srdf")))


def read_srdf(path: Path) -> tuple[tuple[str, str], ...]:
    """Pairs of links that must not collide; none if there is no such file."""
    if not path.is_file():
        return ()
    pairs = ET.parse(path).getroot().findall("disable_collisions")
    return tuple((pair.get("link1", ""), pair.get("link2", "")) for pair in pairs)


def read_asset(folder: Path) -> Asset:
    """The `asset.json` of an asset folder."""
    return read_json(Asset, Path(folder) / "asset.json", AGAIN)


def urdf_of(folder: Path, asset: Asset) -> Path:
    """The URDF of an asset, which lies in its folder."""
    path = Path(folder) / asset.urdf
    if not path.resolve().is_relative_to(Path(folder).resolve()):
        what = f"urdf: '{asset.urdf}' lies outside the asset's folder."
        raise InputError(Path(folder) / "asset.json", what, code="E-FILE-OUTSIDE")
    return path


def checksum(folder: Path) -> str:
    """sha256 over the names and bytes of all files of the folder but asset.json, in order of name."""
    digest = hashlib.sha256()
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "asset.json")
    for path in files:
        content = path.read_bytes()
        digest.update(f"{path.relative_to(folder).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


@contextmanager
def atomic_folder(out: Path) -> Iterator[Path]:
    """A temporary folder that takes the place of `out` only if the block succeeds."""
    out = Path(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    folder = make_partial_path(out)
    folder.mkdir()
    try:
        with name_file_in_errors(out):
            yield folder
            ask_before_writing(out)
            forget(out)
            if out.exists():
                shutil.rmtree(out)
            folder.replace(out)
            record(out)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
