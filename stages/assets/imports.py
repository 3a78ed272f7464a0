"""Import the user's own models: URDF, GLB or OBJ files, sorted in folders by category."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import trimesh
from pydantic import Field

from stages.articulated.mesh_reader import convex_pieces, load_meshes
from stages.articulated.model import Link, RobotModel, closed_box, rebased, stretched
from stages.articulated.stretch import write_imported
from stages.articulated.urdf_reader import DENSITY, MINIMUM_INERTIA, MINIMUM_MASS, read_urdf
from stages.cli import progress
from stages.contracts.errors import InputError
from stages.contracts.files import Contract, read_json
from stages.contracts.library import Asset
from stages.geometry.frames import rigid

KINDS = (".urdf", ".glb", ".obj")  # of the files in a folder, the first kind that occurs
Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


class Notes(Contract):
    """Optional `asset.json` beside an imported model: what its geometry does not tell."""

    category: str | None = Field(None, description="default: the name of the folder")
    front: Axis | None = Field(None, description="direction of the front in the file; default +x, or +z where up is +y")
    up: Axis | None = Field(None, description="direction up in the file; default +z, for GLB +y (glTF's rule)")
    scale: float = Field(1.0, gt=0, description="metres per unit of the file")
    mass: float | None = Field(None, gt=0, description="kg; default from the file, or 500 kg / m^3")
    symmetry: Literal["none", "half_turn", "quarter_turn", "full"] = "none"
    placement: Literal["floor", "object", "wall"] = "floor"
    licence: str = "unknown"
    provenance: str | None = None


def import_folders(folders: list[Path], models: Path) -> list[Asset]:
    """Write an asset folder below `models` for every model of <folder>/<category>/...

    Raises:
        InputError: a folder is missing or empty, or a model is broken (file and element named).
    """
    found = []
    for folder in folders:
        if not folder.is_dir():
            raise InputError("assets.folders", f"{folder} is not a folder.")
        files = [(folder, path) for path in model_files(folder)]
        if not files:
            raise InputError(folder, "holds no URDF, GLB or OBJ.", "expected <folder>/<category>/<model>")
        found += files
    return [import_model(path, folder, models) for folder, path in progress(found, "imports", len(found))]


def model_files(folder: Path) -> list[Path]:
    """Model files of <folder>/<category>: those lying there, and of each sub-folder its URDFs, else GLBs, else OBJs."""
    files = []
    for category in sorted(path for path in folder.iterdir() if path.is_dir()):
        for child in sorted(category.iterdir()):
            if child.is_file() and child.suffix.lower() in KINDS:
                files.append(child)
            elif child.is_dir():
                by_kind = [[p for p in sorted(child.rglob("*")) if p.suffix.lower() == kind] for kind in KINDS]
                files += next((group for group in by_kind if group), [])
    return files


def import_model(path: Path, folder: Path, models: Path) -> Asset:
    """Write the asset folder of one model file."""
    notes_file = path.parent / "asset.json"
    notes = read_json(Notes, notes_file) if notes_file.exists() else Notes()
    category = word(notes.category or path.relative_to(folder).parts[0])
    name = word(f"{category}_{path.stem}")
    robot = read_urdf(path, folder) if path.suffix.lower() == ".urdf" else single_body(path)
    robot = upright(robot, notes, gltf=path.suffix.lower() == ".glb")
    if notes.mass is not None:
        robot = with_mass(robot, notes.mass)
    about = {
        "id": name,
        "category": category,
        "licence": notes.licence,
        "provenance": notes.provenance or f"imported: {path.relative_to(folder).as_posix()}",
        "symmetry": notes.symmetry,
        "placement": notes.placement,
    }
    if (closed_box(robot)[1] - closed_box(robot)[0]).min() < 1e-4:
        raise InputError(path, "is flat: one of its extents is zero.")
    return write_imported(robot, models / name, about)


def word(text: str) -> str:
    """Lower-case letters, digits and underscores."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "model"


def single_body(path: Path) -> RobotModel:
    """A mesh file as a thing of one link, with the convex hulls of its bodies to collide."""
    meshes = load_meshes(path)
    pieces = [piece for mesh in meshes for piece in convex_pieces(mesh)]
    hull = trimesh.convex.convex_hull(np.concatenate([piece.vertices for piece in pieces]))
    mass = max(float(hull.volume) * DENSITY, MINIMUM_MASS)
    inertia = hull.moment_inertia * (mass / hull.volume) + MINIMUM_INERTIA * np.eye(3)
    return RobotModel(path.stem, {"base": Link("base", meshes, pieces, mass, hull.center_mass, inertia)})


def upright(robot: RobotModel, notes: Notes, gltf: bool) -> RobotModel:
    """The model with z up, its front towards +x, in metres."""
    up = notes.up or ("+y" if gltf else "+z")
    front = notes.front or ("+z" if up == "+y" else "+x")
    x, z = vector(front), vector(up)
    if abs(x @ z) > 0.5:
        raise InputError("asset.json", f"front {front} and up {up} lie along one line.", "give two different axes")
    rotation = np.array([x, np.cross(z, x), z])
    robot = rebased(robot, rigid(rotation, np.zeros(3)))
    return stretched(robot, (notes.scale,) * 3) if notes.scale != 1.0 else robot


def vector(axis: Axis) -> np.ndarray:
    """Unit vector of '+x', '-x', ..."""
    return (1.0 if axis[0] == "+" else -1.0) * np.eye(3)["xyz".index(axis[1])]


def with_mass(robot: RobotModel, mass: float) -> RobotModel:
    """The model with another total mass, spread as before."""
    ratio = mass / sum(link.mass for link in robot.links.values())
    links = {n: replace(link, mass=link.mass * ratio, inertia=link.inertia * ratio) for n, link in robot.links.items()}
    return replace(robot, links=links)
