"""The true models' surfaces, and how far those of chosen models are from them."""

from functools import cache
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benchmarks.open_rooms import packs
from roomkin.stages.evaluation.scoring import CHAMFER_POINTS, DENSE, sample_surface

ROOT: list[Path] = []  # the folder that is scored: models are read from it


@cache
def _models(half: str) -> dict[str, packs.PackModel]:
    return {one.id: one for one in packs.models(ROOT[0] / "packs", half)}


def find_model(model: str, half: str) -> packs.PackModel:
    """A true model of a half, by its id."""
    return _models(half)[model]


@cache
def _surface_of(model: str, half: str) -> NDArray[np.float64]:
    """Points (CHAMFER_POINTS, 3) of a true model in the unit box."""
    found = find_model(model, half)
    mesh = trimesh.util.concatenate([trimesh.Trimesh(p.vertices, p.faces, process=False) for p in found.parts])
    points = np.asarray(trimesh.sample.sample_surface(mesh, CHAMFER_POINTS, seed=0)[0])
    low, high = mesh.bounds
    return np.asarray((points - low) / np.maximum(high - low, 1e-9))


@cache
def measure_chamfer(model: str, half: str, chosen: Path, size: tuple[float, float, float]) -> float:
    """Between a true model and the library's model in the folder `chosen`, both in a box of `size`."""
    return chamfer(_surface_of(model, half), sample_surface(chosen)[:: DENSE // CHAMFER_POINTS], size)


def chamfer(one: NDArray[np.float64], other: NDArray[np.float64], size: tuple[float, float, float]) -> float:
    """Mean distance of two surfaces (N, 3), each in the unit box, in a box of `size`, over its diagonal."""
    a, b = one * np.array(size), other * np.array(size)
    distances = np.concatenate([cKDTree(b).query(a)[0], cKDTree(a).query(b)[0]])
    return float(distances.mean() / np.linalg.norm(size))
