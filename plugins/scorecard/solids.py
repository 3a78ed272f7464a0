"""Things as solids: of a surface, convex pieces that a physics engine takes, and what is filled of its box."""

from collections.abc import Mapping, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.plugins.scorecard.submission import Cells
from roomkin.stages.evaluation.scoring import DENSE, fill_cells
from roomkin.stages.geometry.boxes import UprightBox

Floats = NDArray[np.float64]
# V-HACD's: half a second a thing; one thread, so that the same surface gives the same pieces.
CUT = {"maxConvexHulls": 16, "resolution": 30_000, "maxNumVerticesPerCH": 32, "asyncACD": False}
THIN = 1e-4  # metres: what is thinner has no volume
SLACK = 0.02  # metres by which pieces may miss an end of the surface


def cut_solid(surface: trimesh.Trimesh, box: UprightBox) -> list[Floats]:
    """Corners (N, 3) of convex pieces of a thing, in the frame of its box; none: it has no volume that can be cut.

    Args:
        surface: of the thing, as it was submitted.
        box: in the world, which may be the larger or the smaller by one factor.
    """
    whole = trimesh.Trimesh(surface.vertices * (box.size / np.maximum(surface.extents, THIN)), surface.faces)
    try:
        pieces = trimesh.decomposition.convex_decomposition(whole, **CUT)
    except Exception:  # a library's, on a surface from elsewhere: its box stands for it
        return []
    hulls = [np.asarray(piece["vertices"], dtype=float) for piece in pieces]
    hulls = [hull for hull in hulls if len(hull) > 3 and _is_thick(hull)]
    ends = np.concatenate(hulls) if hulls else np.zeros((1, 3))
    covers = np.abs(np.stack([ends.min(axis=0), ends.max(axis=0)]) - whole.bounds).max() <= SLACK
    return hulls if covers else []


def _is_thick(hull: Floats) -> bool:
    """Whether no direction is thinner than `THIN`."""
    return bool(np.linalg.svd(hull - hull.mean(axis=0), compute_uv=False)[-1] / np.sqrt(len(hull)) > THIN)


def cut_solids(solids: Mapping[int, trimesh.Trimesh], boxes: Sequence[UprightBox]) -> dict[int, list[Floats]]:
    """Convex pieces by place in the list, of the things that have some."""
    cut = {place: cut_solid(solid, boxes[place]) for place, solid in solids.items()}
    return {place: pieces for place, pieces in cut.items() if pieces}


def fill_solid(surface: trimesh.Trimesh) -> Cells:
    """What is filled of a thing's box, along its own axes."""
    points = np.asarray(trimesh.sample.sample_surface(surface, DENSE, seed=0)[0])
    low, high = surface.bounds
    return fill_cells((points - low) / np.maximum(high - low, 1e-9))
