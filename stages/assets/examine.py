"""What one model of a user's folder is taken for; its files and notes, written where the user can correct them."""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
from PIL import Image
from pydantic import ConfigDict, Field, TypeAdapter

from stages.articulated.asset_folder import atomic_folder
from stages.articulated.model import RobotModel
from stages.articulated.sense import front_direction, squared
from stages.articulated.urdf_reader import read_urdf
from stages.articulated.urdf_writer import write_urdf
from stages.assets.apart import apart
from stages.assets.convention import NOTHING, Evidence, Shared, evidence
from stages.assets.discover import NUMBERED, WHOLE, Found
from stages.assets.importers import Axis, Importer
from stages.assets.importers.urdf import IMPORTER as URDF
from stages.assets.imports import (
    ModelFile,
    Notes,
    import_file,
    in_one_line,
    standing,
    with_notes,
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
from stages.contracts.files import Contract, read_json, write_json
from stages.contracts.library import Asset, Joint
from stages.procedural.catalogue import CATEGORIES

NOTES = "asset.json"
STORAGE = ("bottom_cabinet", "wardrobe")  # both are StorageFurniture in PartNet


@dataclass
class Examined:
    """A model: where it was and is, the notes that count for it, how they came about, what it became, what is doubtful.

    asset None: it cannot be used, for the last of the doubts.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    source: Path
    folder: Path
    notes: Notes | None = None
    told: list[str] = field(default_factory=list)
    asset: Asset | None = None
    doubts: list[str] = field(default_factory=list)
    picture: Annotated[Image.Image | None, Field(exclude=True)] = None

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


class Read(Contract):
    """A model that was read: what its reader left out, and what it tells of its file."""

    remarks: tuple[str, ...]
    evidence: Evidence


def read(found: Found, importer: Importer, place: Path) -> Read:
    """Write a model into the folder `place`, in a process of its own: as it is in its file; notes there stay.

    Raises:
        InputError: it cannot be used.
    """

    def work() -> str:
        with in_one_line(found.path):
            robot = with_notes(found, importer).importer.read(found.path, found.folder)
            write_model(robot, place)
            return Read(remarks=robot.remarks, evidence=evidence(robot, found.category)).model_dump_json()

    return Read.model_validate_json(apart(found.path, work))


def examined(
    found: Found,
    importer: Importer,
    place: Path,
    work: Path,
    before: Sequence[Examined],
    shared: Shared = NOTHING,
    category: str | None = None,
) -> Examined:
    """Say what a model that was read into `place` is taken for; its asset is made below `work`, in another process.

    Notes that were written by hand count and stay as they are; of the others what is not told is guessed.

    Args:
        before: models that it may be a copy of.
        shared: what such files in its folder have in common.
        category: of it; None: what its names say.
    """
    kind = TypeAdapter(Examined)
    named = found if category is None else found._replace(category=category)
    try:
        told = apart(found.path, lambda: kind.dump_json(_examined(named, importer, place, work, shared)).decode())
    except InputError as error:
        return Examined(found.path, place, doubts=[str(error).removeprefix(f"{found.path}: ")])
    model = kind.validate_json(told)
    asset = model.asset
    twin = next((other for other in before if asset and other.asset and other.asset.checksum == asset.checksum), None)
    if twin is not None:
        model.asset = None
        model.doubts.append(f"is a copy of {twin.source}")
        shutil.rmtree(place)
    return model


def _examined(found: Found, importer: Importer, place: Path, work: Path, shared: Shared) -> Examined:
    model, written = Examined(found.path, place), place / "model.urdf"
    try:
        with in_one_line(found.path):
            file = with_notes(found, importer)
            theirs = read_json(Notes, place / NOTES) if (place / NOTES).is_file() else None
            if theirs is not None and theirs.by_hand:
                model.notes = theirs
                model.told.append(f"as {NOTES} says")
            else:
                model.notes, model.told = guessed(read_urdf(written, place), file, shared)
                if file.category not in CATEGORIES:
                    if model.notes.scale not in (file.notes.scale, file.notes.scale * (shared.unit or 1.0)):
                        unit = UNITS[round(model.notes.scale / file.notes.scale, 6)]
                        model.doubts.append(f"of such things no size is known: that it is in {unit} is a guess")
                    model.told.append("a category of its own: none of ours is called so")
                write_json(place / NOTES, model.notes.sealed())
            as_written = Found(written, place.parent.parent, place.parent.name, place.name)
            asset, doubts = import_file(with_notes(as_written, URDF), work)
            model.doubts += doubts
    except InputError as error:
        model.doubts.append(str(error).removeprefix(f"{found.path}: ").removeprefix(f"{written}: "))
        return model
    model.asset = asset
    if doubt := doubt_of_size(asset.size, asset.category):
        model.doubts.append(doubt)
    return model


def guessed(robot: RobotModel, file: ModelFile, shared: Shared = NOTHING) -> tuple[Notes, list[str]]:
    """The notes beside a model, with what they do not say; and how that was found, in lines."""
    notes, lines = file.notes, []
    up, scale, category = notes.up, notes.scale, file.category
    kind, tells = file.path.suffix.lower(), evidence(robot, category)
    if up is None:
        up, how = told_up(robot, file, tells, shared)
        extents = np.array(tells.extents) * scale
        if file.path.name in NUMBERED and category == STORAGE[0]:
            category = likest(extents, STORAGE)
        if file.path.name in NUMBERED and (known := scale_from_sphere(extents, category)):
            scale *= known
            lines.append("as large as ours are: its file has it in a sphere of radius 1, as all of PartNet")
        else:
            # Proportions tell up only where nothing else does: an upright box is no book that stands on its edge.
            ups = [up, other_up(up)] if not how and not file.importer.has_up and tells.stands is None else [up]
            up, unit = up_and_unit(extents, category, ups, kind in WHOLE, shared.unit)
            scale *= unit
            if unit != 1.0:
                told = f"as most {kind} here" if unit == shared.unit else "by its size"
                lines.append(
                    f"in {UNITS[unit]} {told}" if unit in UNITS else "as large as ours are: it is in no usual unit"
                )
        if not how and up != file.importer.up:
            how = f"up {up} by its proportions"
        lines += [how] if how else []
    front: Axis | None = notes.front
    if front is None:
        told_front = tells.fronts.get(up)
        default: Axis = "+z" if up == "+y" else "+x"
        if told_front is not None:
            opens = front_direction(squared(standing(robot, up))[0])
            how = f"front where {opens[1]} of its doors and drawers open" if opens else "front away from its back"
            front = told_front
        elif shared.front is not None and shared.front[1] != up[1]:
            front, how = shared.front, f"front {shared.front} as most {kind} here"
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


def told_up(robot: RobotModel, file: ModelFile, tells: Evidence, shared: Shared) -> tuple[Axis, str]:
    """The direction up of a model, and what tells it; empty: it is what is agreed, or assumed."""
    agreed = file.importer.up
    if shared.up is not None and not (file.importer.has_up and shared.up == agreed):
        return shared.up, f"up {shared.up} as most {file.path.suffix.lower()} here"
    if tells.slides not in (None, agreed) and tells.stands != agreed:
        assert tells.slides is not None
        return tells.slides, f"up {tells.slides}: so its drawers slide level"
    if len(robot.links) == 1:
        (body,) = robot.links.values()
        points = np.concatenate([visual.mesh.vertices for visual in body.visuals])
        up = up_as_it_stands(points, file.category, agreed, file.importer.has_up)
        return up, f"up {up}: only so it stands" if up != agreed else ""
    return agreed, ""


def write_model(robot: RobotModel, place: Path) -> None:
    """Write the model in its file's own frame and unit, beside notes that are there; masses that nobody told are left
    out."""
    with atomic_folder(place) as folder:
        write_urdf(robot, folder)
        path = folder / "model.urdf"
        tree = ET.parse(path)
        for element in tree.getroot().findall("link"):
            if not robot.links[element.get("name", "")].weighed:
                element.remove(element.find("inertial"))  # type: ignore[arg-type]
        tree.write(path, encoding="utf-8")
        if (place / NOTES).is_file():
            shutil.copy(place / NOTES, folder / NOTES)


def described(joint: Joint) -> str:
    """A door or drawer in one line."""
    reach = f"{np.rad2deg(joint.upper - joint.lower):.0f} degrees"
    if joint.type == "prismatic":
        reach = f"{100 * (joint.upper - joint.lower):.0f} cm"
    hinge = f", hinge {joint.panel.hinge}" if joint.panel is not None and joint.role == "door" else ""
    return f"{joint.role} '{joint.name}': {reach}{hinge}, {f'handle: {joint.handle}' if joint.handle else 'no handle'}"
