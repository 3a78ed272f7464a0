"""A model of the library in the unit box, to cast rays at: that needs no Vulkan, and a few milliseconds."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import open3d as o3d

from roomkin.stages.articulated.asset_folder import read_asset, urdf_of
from roomkin.stages.articulated.model import frames_of
from roomkin.stages.articulated.urdf_reader import UrdfReader
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import transform_points
from roomkin.stages.geometry.solids import find_outermost


class Solid:
    """The visible surface of a model, every joint closed, scaled so that its box is [-0.5, 0.5]^3.

    A box in a scene is an affine map of the unit box, so rays are mapped, never the triangles. visuals: what `scene`
    consists of, one after the other. outermost: vertices (N, 3) that every outline is made of.

    Raises:
        InputError: it is not whole.
    """

    def __init__(self, folder: Path) -> None:
        self.asset = read_asset(folder)
        reader = UrdfReader(urdf_of(folder, self.asset), folder)
        by_link = {name: reader.visuals(name) for name in reader.tree.links}
        if reader.remarks:
            raise InputError(reader.path, reader.remarks[0], code="E-MODEL-BROKEN")
        frames = frames_of(reader.tree.root, reader.joints)
        low, size = np.array(self.asset.box_min), np.maximum(self.asset.size, 1e-6)
        self.visuals = [visual for visuals in by_link.values() for visual in visuals]
        vertices = [
            (transform_points(frames[name], visual.mesh.vertices) - low) / size - 0.5
            for name, visuals in by_link.items()
            for visual in visuals
        ]
        starts = np.cumsum([0, *map(len, vertices[:-1])])
        faces = [visual.mesh.faces + start for visual, start in zip(self.visuals, starts, strict=True)]
        self.outermost = find_outermost(np.concatenate(vertices))
        self.scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.scene.add_triangles(
            o3d.core.Tensor.from_numpy(np.concatenate(vertices).astype(np.float32)),
            o3d.core.Tensor.from_numpy(np.concatenate(faces).astype(np.uint32)),
        )


@lru_cache(maxsize=64)
def read_solid(folder: Path) -> Solid:
    """The solid of a model of the library."""
    return Solid(folder)
