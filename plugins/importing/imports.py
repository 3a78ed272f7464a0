"""Import the user's own models: files of the kinds in `importers`, sorted in folders by category."""

import json
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np
from pydantic import Field, ValidationError

from roomkin.plugins.importing.discover import WHOLE, Given, discover
from roomkin.plugins.importing.fronts import align_to_axes, doors_and_drawers, front_direction
from roomkin.plugins.importing.hinges import shut_where_smallest
from roomkin.plugins.importing.importers import IMPORTERS, Axis, Importer
from roomkin.plugins.importing.proposal import ProposedFile
from roomkin.plugins.importing.repairs import (
    find_touching_links,
    repair_inertias,
    stuck_joints,
    with_mass,
    with_solid_handles,
)
from roomkin.plugins.importing.sandbox import check_inside, number_names, run_in_fork, snake_case
from roomkin.plugins.importing.single_body import leave_out
from roomkin.stages.articulated.asset_folder import Description, assign_part_types, read_asset, write_asset
from roomkin.stages.articulated.handle import explain_ungraspable
from roomkin.stages.articulated.mesh_reader import thicken_piece
from roomkin.stages.articulated.model import Matrix, RobotModel, change_root, link_frames, measure_closed_box
from roomkin.stages.articulated.resizing import stretch_model
from roomkin.stages.articulated.urdf_tree import THIN
from roomkin.stages.assets.snapshots import VisibilityCheck
from roomkin.stages.cli import progress
from roomkin.stages.contracts.errors import InputError, escape_control, explain
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.library import Asset, Placement, Symmetry
from roomkin.stages.contracts.types import LARGEST, Mass
from roomkin.stages.geometry.frames import make_transform, yaw_matrix
from roomkin.stages.geometry.solids import board_mass
from roomkin.stages.plugins import load, shorten_name


class Notes(ProposedFile):
    """Optional `asset.json` beside an imported model: what its geometry does not tell."""

    category: str | None = Field(None, description="default: the name of the folder")
    front: Axis | None = Field(
        None, description="direction of the front in the file; default where doors open, else +x, or +z where up is +y"
    )
    up: Axis | None = Field(None, description="direction up in the file; default +z, for GLB +y (glTF's rule)")
    without: tuple[str, ...] = Field((), description="nodes of a mesh file (GLB, DAE, OBJ) to leave out, as its ground")
    scale: float = Field(1.0, ge=1e-6, le=1e6, description="metres per unit of the file")
    mass: Mass | None = Field(None, description="kg; default from the file, or that of boards")
    symmetry: Symmetry = "none"
    placement: Placement = "floor"
    licence: str = "unknown"
    provenance: str | None = None


class ModelFile(NamedTuple):
    """A model file of a user's folder and what its asset will be called."""

    path: Path
    folder: Path
    notes: Notes
    category: str
    id: str
    importer: Importer

    @property
    def notes_path(self) -> Path:
        """The file of the notes, there or not."""
        return self.path.parent / "asset.json"


def named_models(folders: Sequence[Path], kinds: dict[str, Importer], taken: Iterable[str] = ()) -> dict[str, Given]:
    """The models of <folder>/<category>/... by what they will be called; names that are taken get a number.

    Raises:
        InputError: a folder is missing or empty.
    """
    found: list[Given] = []
    for folder in dict.fromkeys(folders):
        if not folder.is_dir():
            raise InputError("assets.folders", f"{folder} is not a folder.", code="E-MODELS-NONE")
        models = discover(folder, list(kinds))
        if not models:
            mend = "see docs/your-models.md for the layout"
            raise InputError(folder, f"holds no model ({', '.join(kinds)}).", mend, code="E-MODELS-NONE")
        found += models
    return dict(zip(number_names([_name(one, kinds) for one in found], taken), found, strict=True))


def _name(found: Given, kinds: dict[str, Importer]) -> str:
    try:
        return with_notes(found, kinds[found.path.suffix.lower()]).id
    except InputError:  # the import reports it
        return snake_case(f"{found.category}_{found.name}")


def import_models(models: dict[str, Given], kinds: dict[str, Importer], folder: Path) -> tuple[list[Asset], list[str]]:
    """Write an asset folder below `folder` for every model, by name; and what is left out as broken, in a line each."""
    assets, left_out, visibility = [], [], VisibilityCheck()
    for name, found in progress(models.items(), "imports", len(models)):
        try:
            doubts = json.loads(run_in_fork(found.path, partial(_import_one, name, found, kinds, folder)))
            with in_one_line(found.path):
                visibility.check(folder / name, found.path)
                assets.append(read_asset(folder / name))
        except InputError as error:
            left_out.append(str(error))
            print(f"left out: {error}")
            shutil.rmtree(folder / name, ignore_errors=True)
            continue
        for doubt in doubts:
            print(escape_control(f"{found.path}: {doubt}"))
    return assets, left_out


def _import_one(name: str, found: Given, kinds: dict[str, Importer], folder: Path) -> str:
    """JSON of what is doubtful."""
    with in_one_line(found.path):
        file = with_notes(found, kinds[found.path.suffix.lower()])
        return json.dumps(import_file(file._replace(id=name), folder)[1])


@contextmanager
def in_one_line(path: Path) -> Iterator[None]:
    """Whatever a model makes mesh and physics libraries raise becomes its one line: it must not stop the others."""
    try:
        with np.errstate(all="ignore"):  # what divides by the volume of a flat piece is checked by its result
            yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        said = (str(error).splitlines() or [""])[0][:200]
        what = f"cannot be imported: {explain(error)}" + (f" ({said})." if said else ".")
        raise InputError(path, what, code="E-MODEL-IMPORT") from error


def by_suffix(importers: Sequence[str]) -> dict[str, Importer]:
    """Importers by the suffix of their files, which most are named after; `importers` empty: all of this package."""
    loaded = {name: load("importers", name) for name in importers or IMPORTERS}
    return {importer.suffix or f".{shorten_name(name)}": importer for name, importer in loaded.items()}


def with_notes(found: Given, importer: Importer) -> ModelFile:
    """A model file with the notes beside it.

    Raises:
        InputError: the notes are broken, or one of the two is a link out of the user's folder, or no file.
    """
    check_inside(found.path, found.folder)
    path, notes = found.path.parent / "asset.json", Notes()
    if path.exists():
        check_inside(path, found.folder)
        notes = read_json(Notes, path)
    category = snake_case(notes.category or found.category)
    return ModelFile(found.path, found.folder, notes, category, snake_case(f"{category}_{found.name}"), importer)


def read_model(file: ModelFile) -> RobotModel:
    """The model of a file, its doors and drawers shut, without the nodes that its notes leave out."""
    robot = file.importer.read(file.path, file.folder)
    if file.notes.without and file.path.suffix.lower() not in WHOLE:
        robot = leave_out(robot, file.notes.without, file.path)
    return shut_where_smallest(robot)


def import_file(file: ModelFile, models: Path) -> tuple[Asset, list[str]]:
    """Write the asset folder of one model; what is doubtful about it, in lines."""
    path, notes = file.path, file.notes
    robot, turned = turn_upright(read_model(file), file)
    robot, fixed = doors_and_drawers(robot)
    robot = assign_part_types(robot)
    check_believable(robot, path)
    robot, weighed = repair_inertias(robot)
    if notes.mass is not None:
        robot, weighed = with_mass(robot, notes.mass), []
    robot, cut = with_solid_handles(without_specks(robot))
    about = Description(
        id=file.id,
        category=file.category,
        licence=notes.licence,
        provenance=notes.provenance or f"imported: {path.relative_to(file.folder).as_posix()}",
        symmetry=notes.symmetry,
        placement=notes.placement,
    )
    try:
        asset = write_asset(robot, models / file.id, about)
        if touching := find_touching_links(models / file.id):
            asset = write_asset(replace(robot, touching=touching), models / file.id, about)
    except ValidationError as error:
        raise InputError(path, f"makes no asset: {error.errors()[0]['msg']}.", code="E-MODEL-IMPORT") from None
    bare = {joint.name for joint in asset.joints if joint.handle is None}
    held = [
        f"{joint.part_type} '{joint.name}' cannot be grasped: {explain_ungraspable(robot, joint, link_frames(robot))}"
        for joint in robot.joints
        if joint.name in bare
    ]
    return asset, [*robot.remarks, *turned, *fixed, *weighed, *cut, *held, *stuck_joints(models / file.id)]


def check_believable(robot: RobotModel, path: Path) -> None:
    """Refuse what is flat or larger than a house.

    Raises:
        InputError: names the extent.
    """
    low, high = measure_closed_box(robot)
    extents = high - low
    size = " x ".join(f"{extent:.4g}" for extent in extents)
    if extents.min() < THIN:
        raise InputError(path, f"is flat: its extents are {size} m.", "0.1 mm at least", code="E-MODEL-FLAT")
    if extents.max() > LARGEST:
        mend = f"at most {LARGEST:g} m; see scale in asset.json"
        raise InputError(path, f"is {size} m large.", mend, code="E-MODEL-SIZE")
    if np.abs(np.array([low, high])).max() > 5 * LARGEST:
        mend = "move it there"
        raise InputError(path, f"lies {np.abs([low, high]).max():.4g} m from its origin.", mend, code="E-MODEL-SIZE")


def turn_upright(robot: RobotModel, file: ModelFile) -> tuple[RobotModel, list[str]]:
    """The model with z up, its front towards +x, in metres; and a line if it was turned though nobody asked."""
    notes, lines = file.notes, []
    up = notes.up or file.importer.up
    front = notes.front or guess_front(up)
    if front[1] == up[1]:
        what = f"front {front} and up {up} lie along one line."
        raise InputError(file.notes_path, what, "give two different axes", code="E-MODEL-AXES")
    robot = turn_to_axes(robot, up, front)
    if notes.scale != 1.0:
        robot = in_metres(robot, notes.scale)
    robot, turn = align_to_axes(robot)
    if turn:
        lines.append(f"turned by {np.rad2deg(turn):.0f} degrees, to face along an axis")
    if notes.front is None and (facing := front_direction(robot)) is not None and facing[0][0] < 1:
        (x, y, _), count = facing
        lines += [f"turned to face +x, where {count} of its doors and drawers open (asset.json: front)"]
        robot = change_root(robot, make_transform(yaw_matrix(-float(np.arctan2(y, x))).round(9), np.zeros(3)))
    return robot, lines


def guess_front(up: Axis) -> Axis:
    """The axis of a file that most models face, where `up` is up."""
    return "+z" if up == "+y" else "+y" if up[1] == "x" else "+x"


def turn_to_axes(robot: RobotModel, up: Axis, front: Axis) -> RobotModel:
    """The model with the file's axis `up` as z, and `front` as x."""
    return change_root(robot, make_transform(_axes(front, up), np.zeros(3)))


def in_file(direction: np.ndarray, front: Axis, up: Axis) -> Axis:
    """The axis of the file that is a direction of the model, once `front` of the file is its +x and `up` its +z."""
    wanted = _axes(front, up).T @ direction
    return max(get_args(Axis), key=lambda axis: float(axis_vector(axis) @ wanted))


def _axes(front: Axis, up: Axis) -> Matrix:
    """(3, 3): the model's x, y, z as rows, in the file's frame."""
    x, z = axis_vector(front), axis_vector(up)
    return np.array([x, np.cross(z, x), z])


def in_metres(robot: RobotModel, scale: float) -> RobotModel:
    """The model in metres, `scale` of which are one unit of its file; masses that the file tells are kilograms."""
    robot, volume = stretch_model(robot, (scale,) * 3), scale**3
    links = {}
    for name, link in robot.links.items():
        wanted = link.mass / volume if link.weighed else board_mass(link.collisions, link.visuals)
        links[name] = replace(link, mass=wanted, inertia=link.inertia * (wanted / link.mass))
    return replace(robot, links=links)


def without_specks(robot: RobotModel) -> RobotModel:
    """The model (in metres) without what is a thread or a dot; thin pieces that collide made thick."""
    links = {
        name: replace(
            link,
            visuals=[visual for visual in link.visuals if np.sort(visual.mesh.extents)[1] > THIN],
            collisions=[thicken_piece(piece) for piece in link.collisions if piece.extents.max() > THIN],
        )
        for name, link in robot.links.items()
    }
    return replace(robot, links=links)


def axis_vector(axis: Axis) -> Matrix:
    """Unit vector of '+x', '-x', ..."""
    return (1.0 if axis[0] == "+" else -1.0) * np.eye(3)["xyz".index(axis[1])]
