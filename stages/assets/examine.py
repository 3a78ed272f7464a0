"""What one model of a user's folder is taken for; its files and notes, written where the user can correct them."""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import get_args

import numpy as np
from PIL import Image

from stages.articulated.asset_folder import atomic_folder
from stages.articulated.forward_kinematics import closed_box
from stages.articulated.model import RobotModel
from stages.articulated.sense import front_direction
from stages.articulated.urdf_writer import write_urdf
from stages.assets.convention import NOTHING, Shared
from stages.assets.discover import NUMBERED, WHOLE, Found
from stages.assets.facing import front_before_back
from stages.assets.importers import Axis, Importer
from stages.assets.importers.urdf import IMPORTER as URDF
from stages.assets.imports import (
    ModelFile,
    Notes,
    axis_vector,
    import_file,
    in_one_line,
    upright,
    with_notes,
    without_specks,
)
from stages.assets.proportions import (
    UNITS,
    doubt_of_size,
    likest,
    other_up,
    scale_from_sphere,
    up_and_unit,
    up_as_it_stands,
)
from stages.contracts.errors import InputError
from stages.contracts.files import read_json, write_json
from stages.contracts.library import Asset, Joint
from stages.procedural.catalogue import CATEGORIES

NOTES = "asset.json"
STORAGE = ("bottom_cabinet", "wardrobe")  # both are StorageFurniture in PartNet


@dataclass
class Examined:
    """A model: where it was and is, the notes that count for it, how they came about, what it became, what is doubtful.

    asset None: it cannot be used, for the last of the doubts.
    """

    source: Path
    folder: Path
    notes: Notes | None = None
    told: list[str] = field(default_factory=list)
    asset: Asset | None = None
    doubts: list[str] = field(default_factory=list)
    picture: Image.Image | None = None

    def facts(self) -> list[str]:
        """What it is taken for, in short."""
        if self.notes is None:
            return []
        notes = self.notes
        facts = [f"{notes.category}", f"front {notes.front}, up {notes.up}, scale {notes.scale:g}", *self.told]
        if self.asset is not None:
            x, y, z = (100 * extent for extent in self.asset.size)
            facts.insert(1, f"{y:.3g} cm wide, {x:.3g} deep, {z:.3g} high, {self.asset.mass:.3g} kg")
        return facts

    def joints(self) -> list[str]:
        """Its doors and drawers, a line each."""
        return [described(joint) for joint in self.asset.joints] if self.asset is not None else []

    def text(self) -> str:
        """All of it, in lines."""
        if self.asset is None:
            return f"{self.source}: not used: {self.doubts[-1]}"
        lines = [f"{self.source}: {'; '.join(self.facts())}"]
        return "\n  ".join([*lines, *self.joints(), *(f"? {doubt}" for doubt in self.doubts)])


def examine(
    found: Found, importer: Importer, place: Path, work: Path, before: Sequence[Examined], shared: Shared = NOTHING
) -> Examined:
    """Write the folder `place` of a model, and its asset below `work`.

    Notes that are there already count and stay as they are; of the others what is not told is guessed. `shared`: what
    such files in its folder have in common.
    """
    model = Examined(found.path, place)
    try:
        with in_one_line(found.path):
            file = with_notes(found, importer)
            robot = importer.read(found.path, found.folder)
            model.doubts += robot.remarks
            theirs = place / NOTES
            corrected = theirs.is_file()
            if corrected:
                notes = read_json(Notes, theirs)
                model.told.append(f"as {NOTES} says")
            else:
                notes, model.told = guessed(robot, file, shared)
                if file.category not in CATEGORIES:
                    if notes.scale not in (file.notes.scale, file.notes.scale * (shared.unit or 1.0)):
                        unit = UNITS[round(notes.scale / file.notes.scale, 6)]
                        model.doubts.append(f"of such things no size is known: that it is in {unit} is a guess")
                    model.told.append("a category of its own: none of ours is called so")
            model.notes = notes
            write_model(without_specks(robot, notes.scale), place, notes)
            as_written = Found(place / "model.urdf", place.parent.parent, place.parent.name, place.name)
            asset, doubts = import_file(with_notes(as_written, URDF), work)
            model.doubts += doubts
    except InputError as error:
        written = place / "model.urdf"
        model.doubts.append(str(error).removeprefix(f"{found.path}: ").removeprefix(f"{written}: "))
        return model
    twin = next((other for other in before if other.asset and other.asset.checksum == asset.checksum), None)
    if twin is not None:
        model.doubts.append(f"is a copy of {twin.source}")
        shutil.rmtree(place)
        return model
    model.asset = asset
    model.doubts += [
        doubt for doubt in (doubt_of_size(asset.size, asset.category), *map(ungraspable, asset.joints)) if doubt
    ]
    return model


def guessed(robot: RobotModel, file: ModelFile, shared: Shared = NOTHING) -> tuple[Notes, list[str]]:
    """The notes beside a model, with what they do not say; and how that was found, in lines."""
    notes, lines = file.notes, []
    up, scale, category = notes.up, notes.scale, file.category
    if up is None:
        low, high = closed_box(robot)
        extents, up = (high - low) * scale, shared.up or file.importer.up
        if file.path.name in NUMBERED and category == STORAGE[0]:
            category = likest(extents, STORAGE)
        if file.path.name in NUMBERED and (known := scale_from_sphere(extents, category)):
            scale *= known
            lines.append("as large as ours are: its file has it in a sphere of radius 1, as all of PartNet")
        else:
            ups = [up] if shared.up else [up, other_up(up)]
            up, unit = up_and_unit(extents, category, ups, file.path.suffix.lower() in WHOLE, shared.unit)
            scale *= unit
            if unit != 1.0:
                how = f"as most {file.path.suffix.lower()} here" if unit == shared.unit else "by its size"
                lines.append(
                    f"in {UNITS[unit]} {how}" if unit in UNITS else "as large as ours are: it is in no usual unit"
                )
        if shared.up:
            lines.append(f"up {up} as most {file.path.suffix.lower()} here")
        elif up != file.importer.up:
            lines.append(f"up {up} by its proportions")
        elif len(robot.links) == 1:
            (body,) = robot.links.values()
            points = np.concatenate([visual.mesh.vertices for visual in body.visuals])
            up = up_as_it_stands(points, category, up, file.importer.has_up)
            if up != file.importer.up:
                lines.append(f"up {up}: only so it stands")
    front: Axis | None = notes.front
    if front is None:
        default: Axis = "+z" if up == "+y" else "+x"
        notes = notes.model_copy(update={"front": default, "up": up, "scale": scale})
        turned, _ = upright(robot, file._replace(notes=notes))
        told, backed = front_direction(turned), front_before_back(turned, category)
        if told is not None:
            front, how = in_file(told[0], default, up), f"front where {told[1]} of its doors and drawers open"
        elif backed is not None:
            front, how = in_file(backed, default, up), "front away from its back"
        else:
            unsure = file.notes.up is None and not shared.up and up == file.importer.up and not file.importer.has_up
            front = default
            how = "front and up assumed" if unsure and category not in CATEGORIES else "front assumed"
        lines.append(how)
    words = {
        "category": category,
        "front": front,
        "up": up,
        "scale": scale,
        "provenance": notes.provenance or f"imported: {file.path.relative_to(file.folder).as_posix()}",
    }
    return notes.model_copy(update=words), lines


def in_file(direction: np.ndarray, front: Axis, up: Axis) -> Axis:
    """The axis of the file that is a direction of the model, once `front` of the file is its +x and `up` its +z."""
    x, z = axis_vector(front), axis_vector(up)
    wanted = np.array([x, np.cross(z, x), z]).T @ direction
    return max(get_args(Axis), key=lambda axis: float(axis_vector(axis) @ wanted))


def write_model(robot: RobotModel, place: Path, notes: Notes) -> None:
    """Write the model in its file's own frame and unit, and its notes; masses that nobody told are left out."""
    with atomic_folder(place) as folder:
        write_urdf(robot, folder)
        path = folder / "model.urdf"
        tree = ET.parse(path)
        for element in tree.getroot().findall("link"):
            if not robot.links[element.get("name", "")].weighed:
                element.remove(element.find("inertial"))  # type: ignore[arg-type]
        tree.write(path, encoding="utf-8")
        write_json(folder / NOTES, notes)


def described(joint: Joint) -> str:
    """A door or drawer in one line."""
    reach = f"{np.rad2deg(joint.upper - joint.lower):.0f} degrees"
    if joint.type == "prismatic":
        reach = f"{100 * (joint.upper - joint.lower):.0f} cm"
    hinge = f", hinge {joint.panel.hinge}" if joint.panel is not None and joint.role == "door" else ""
    return f"{joint.role} '{joint.name}': {reach}{hinge}, {f'handle: {joint.handle}' if joint.handle else 'no handle'}"


def ungraspable(joint: Joint) -> str | None:
    """A line if a gripper finds nothing to hold."""
    if joint.handle is not None:
        return None
    what = "no handle, 12 mm or more out from its front, at most 7 cm wide and before everything else"
    return f"{joint.role} '{joint.name}' cannot be grasped: {what}"
