"""Import one model of a user's folder: its URDF and notes (asset.json), written where the user can correct them."""

import json
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from PIL import Image
from pydantic import ConfigDict, Field, TypeAdapter

from roomkin.plugins.importing import imports
from roomkin.plugins.importing.discover import NUMBERED, Given
from roomkin.plugins.importing.evidence import UNITS, Evidence, Shared, collect_evidence
from roomkin.plugins.importing.importers import Importer
from roomkin.plugins.importing.importers.urdf import IMPORTER as URDF
from roomkin.plugins.importing.sandbox import run_in_fork, snake_case
from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.articulated.model import RobotModel
from roomkin.stages.articulated.urdf_writer import write_urdf
from roomkin.stages.contracts.categories import find_usual_size, known_categories
from roomkin.stages.contracts.category import describe_unusual
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.library import Asset, Joint
from roomkin.stages.contracts.types import LARGEST

NOTES = "asset.json"
TINY = 0.03  # metres: smaller things are in no room that is rebuilt; most are in another unit than they say


@dataclass
class Examined:
    """A model: its source and folder, the notes that count and where they come from, the asset, the doubts.

    asset None: it cannot be used; the last doubt says why.
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    source: Path
    folder: Path
    notes: imports.Notes | None = None
    because: list[str] = field(default_factory=list)
    asset: Asset | None = None
    doubts: list[str] = field(default_factory=list)
    picture: Annotated[Image.Image | None, Field(exclude=True)] = None

    def facts(self) -> list[str]:
        """A summary of what it is taken for."""
        if self.notes is None:
            return []
        notes = self.notes
        facts = [f"{notes.category}", f"front {notes.front}, up {notes.up}, scale {notes.scale:g}", *self.because]
        if self.asset is not None:
            x, y, z = (100 * extent for extent in self.asset.size)
            facts.insert(1, f"{y:.3g} cm wide, {x:.3g} deep, {z:.3g} high, {self.asset.mass:.3g} kg")
        return facts

    def joints(self) -> list[str]:
        """A line for each door and drawer."""
        return [describe_joint(joint) for joint in self.asset.joints] if self.asset is not None else []

    def text(self) -> str:
        """All of it, in lines."""
        if self.asset is None:
            return escape_control(f"{self.source}: not used: {self.doubts[-1]}")
        lines = [f"{self.source}: {'; '.join(self.facts())}", *self.joints(), *(f"? {doubt}" for doubt in self.doubts)]
        return escape_control("\n  ".join(lines))


def read(found: Given, importer: Importer, place: Path) -> Evidence:
    """Write a model into the folder `place`, in a process of its own: as it is in its file; notes there stay.

    Raises:
        InputError: it cannot be used.
    """

    def examine_all() -> str:
        with imports.in_one_line(found.path):
            file = imports.with_notes(found, importer)
            theirs = read_json(imports.Notes, place / NOTES) if (place / NOTES).is_file() else None
            if theirs is not None and theirs.by_hand:
                file = file._replace(notes=file.notes.model_copy(update={"without": theirs.without}))
            robot = imports.read_model(file)
            write_model(robot, place)
            return collect_evidence(robot).model_dump_json()

    return Evidence.model_validate_json(run_in_fork(found.path, examine_all))


def examine_model(
    found: Given,
    importer: Importer,
    place: Path,
    work: Path,
    before: Sequence[Examined],
    tells: Evidence,
    shared: Shared,
    category: str | None = None,
) -> Examined:
    """Complete the notes of a model that was read into `place` and build its asset below `work`, in another process.

    Notes that were written by hand count and stay as they are. In others, what is not stated is inferred.

    Args:
        before: models that it may be a copy of.
        tells: what the model tells of its file.
        shared: what such files in its folder have in common.
        category: of it; None: what its names say.
    """
    kind = TypeAdapter(Examined)
    named = found if category is None else found._replace(category=category)
    examine = partial(_examine_model, named, importer, place, work, tells, shared)
    try:
        answer = run_in_fork(found.path, lambda: kind.dump_json(examine()).decode())
    except InputError as error:
        return Examined(found.path, place, doubts=[explain(error, found.path)])
    model = kind.validate_json(answer)
    asset = model.asset
    twin = next((other for other in before if asset and other.asset and other.asset.checksum == asset.checksum), None)
    if twin is not None:
        model.asset = None
        model.doubts.append(f"is a copy of {twin.source}")
        shutil.rmtree(place)
    return model


def _examine_model(
    found: Given, importer: Importer, place: Path, work: Path, tells: Evidence, shared: Shared
) -> Examined:
    model, written = Examined(found.path, place), place / "model.urdf"
    try:
        with imports.in_one_line(found.path):
            file = imports.with_notes(found, importer)
            theirs = read_json(imports.Notes, place / NOTES) if (place / NOTES).is_file() else None
            if theirs is not None and theirs.by_hand:
                model.notes = theirs
                model.because.append(f"as {NOTES} says")
            else:
                model.notes, model.because = complete_notes(file, tells, shared)
                model.doubts += doubt_up(file, tells, shared)
                write_json(place / NOTES, model.notes.add_checksum())
            as_written = Given(written, place.parent.parent, place.parent.name, place.name)
            asset, doubts = imports.import_file(imports.with_notes(as_written, URDF), work)
            model.doubts += doubts
    except InputError as error:
        model.doubts.append(explain(error, found.path, written))
        return model
    model.asset = asset
    if asset.category not in known_categories() and asset.category == snake_case(found.category) != file.notes.category:
        model.doubts.append(describe_unknown(asset.category))
    if odd := describe_unusual(known_categories().get(asset.category), asset.size):
        ground = tells.grounds.get(model.notes.up or importer.up, "")
        leave = f"Leave out its ground, '{ground}'? asset.json: \"without\": {json.dumps([ground])}"
        model.doubts.append(f"{odd}. {leave if ground else 'Is the unit right? asset.json: scale'}")
    elif asset.category not in known_categories() and max(asset.size) < TINY:
        model.doubts.append(f"is at most {100 * max(asset.size):.2g} cm large: is the unit right (scale)?")
    return model


def describe_unknown(category: str) -> str:
    """The doubt about a category that the library does not know."""
    mend = f"pack.yaml: categories: {{{category}: chair}}, asset.json: category, or another name of the folder"
    return f"no category of ours is called '{category}': no label may ever mean it. If it is one, say which ({mend})"


def explain(error: InputError, *files: Path) -> str:
    """The message of an error about the first of these files that it names, without the file."""
    text = str(error)
    for file in files:
        text = text.removeprefix(escape_control(f"{file}: "))
    return text


def complete_notes(file: imports.ModelFile, tells: Evidence, shared: Shared) -> tuple[imports.Notes, list[str]]:
    """The notes beside a model, completed: by what the folder's models share, else by the model's own evidence, else
    by what such files usually are. The second value has a line for everything unusual."""
    notes, kind, lines = file.notes, f"most {file.path.suffix.lower()} here", list[str]()
    agreed, evidence = file.importer.up, tells.find_up(file.category, file.importer.up, file.importer.has_up)
    up = notes.up or shared.up or evidence.axis
    if notes.up is None and (up != agreed or (shared.up and not file.importer.has_up)):
        lines.append(f"up {up} {f'as {kind}' if shared.up else f'by its {evidence.because}'}")
    scale, sizes = notes.scale, find_usual_size(file.category)
    if "scale" not in notes.model_fields_set:
        if file.path.name in NUMBERED and sizes and sizes.misfit(tells.order_extents(up)):
            scale = sizes.factor(tells.order_extents(up))
            lines.append("as large as ours are: models of PartNet have no size")
        else:
            scale = shared.unit or tells.unit(file.category, up) or 1.0
            by, largest = f"as {kind}" if shared.unit else "by its size", max(tells.extents)
            if scale * largest > LARGEST:
                by = f"as it would be {scale * largest:.3g} m else"
                scale = tells.find_unit(file.category, up)
            if scale != 1.0:
                lines.append(f"in {UNITS.get(scale, f'units of {scale:g} m')} {by}")
    front, opens = notes.front, tells.fronts.get(up)
    if front is None and opens is not None:
        front = opens
        lines.append("front where its doors and drawers open")
    elif front is None and shared.front is not None and shared.front[1] != up[1]:
        front = shared.front
        lines.append(f"front {front} as {kind}")
    elif front is None:
        front = imports.guess_front(up)
        lines.append("front assumed")
    words = {
        "category": file.category,
        "front": front,
        "up": up,
        "scale": scale,
        "provenance": notes.provenance or f"imported: {file.path.relative_to(file.folder).as_posix()}",
    }
    return notes.model_copy(update=words), lines


def doubt_up(file: imports.ModelFile, tells: Evidence, shared: Shared) -> list[str]:
    """A line if a model seems to lie on its side, though its kind of file says what is up."""
    evidence = tells.find_up(file.category, file.importer.up, file.importer.has_up)
    if file.notes.up or shared.up or not evidence.doubt:
        return []
    return [f"up {evidence.axis} as such files have it, though {evidence.doubt}: does it lie? (asset.json: up)"]


def write_model(robot: RobotModel, place: Path) -> None:
    """Write the model in its file's own frame and unit, beside notes that are there; masses that nobody stated are left
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


def describe_joint(joint: Joint) -> str:
    """A door, drawer or button in one line."""
    reach = f"{np.rad2deg(joint.upper - joint.lower):.0f} degrees"
    if joint.type == "prismatic":
        reach = f"{100 * (joint.upper - joint.lower):.0f} cm"
    hinge = f", hinge {joint.panel.hinge}" if joint.panel is not None and joint.type == "revolute" else ""
    handle = f"handle: {joint.handle}" if joint.handle else "no handle"
    return f"{joint.part_type} '{joint.name}': {reach}{hinge}, {handle}"
