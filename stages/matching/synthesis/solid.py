"""Models of the library in a unit box, and what rays see of them: a ray caster needs no Vulkan, and a few ms."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from stages.articulated.asset_folder import read_asset, urdf_of
from stages.articulated.forward_kinematics import frames_of
from stages.articulated.model import Visual
from stages.articulated.urdf_reader import UrdfReader
from stages.contracts.library import Asset
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import apply, yaw_matrix

UNPAINTED = (0.6, 0.6, 0.6)  # linear
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Seen:
    """What rays (N,) see: depth in units of their directions (0: nothing), unit normals (N, 3) in the frame around the
    box, towards the eye, and colours (N, 3), linear."""

    depth: NDArray[np.float32]
    normals: NDArray[np.float32]
    colour: NDArray[np.float32]


class Solid:
    """The visible surface of an asset, every joint closed, scaled so that its box is [-0.5, 0.5]^3.

    A box in a scene is an affine map of the unit box, so rays are mapped, never the triangles.
    """

    def __init__(self, folder: Path) -> None:
        self.asset: Asset = read_asset(folder)
        reader = UrdfReader(urdf_of(folder, self.asset), folder)
        frames = frames_of(reader.tree.root, reader.joints)
        pieces = [(frames[name], visual) for name in reader.tree.links for visual in reader.visuals(name)]
        low, size = np.array(self.asset.box_min), np.maximum(self.asset.size, 1e-6)
        points = [(apply(frame, visual.mesh.vertices) - low) / size - 0.5 for frame, visual in pieces]
        faces = [np.asarray(visual.mesh.faces) for _, visual in pieces]
        starts = np.cumsum([0, *map(len, points[:-1])])
        self.vertices: Array = np.concatenate(points)
        triangles = np.concatenate([face + start for face, start in zip(faces, starts, strict=True)])
        self._colours = np.repeat([colour_of(visual) for _, visual in pieces], [len(face) for face in faces], axis=0)
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(
            o3d.core.Tensor.from_numpy(self.vertices.astype(np.float32)),
            o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
        )

    def placed(self, box: UprightBox) -> Array:
        """Its vertices (N, 3) when its box is `box`."""
        return self.vertices * np.asarray(box.size) @ yaw_matrix(box.yaw).T + np.asarray(box.center)

    def look(self, origin: Array, directions: Array, box: UprightBox) -> Seen:
        """What rays from `origin` (3,) along `directions` (N, 3) see of it in the box; nobody is inside the box."""
        turn, size = yaw_matrix(box.yaw), np.asarray(box.size, dtype=float)
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3] = (origin - np.asarray(box.center)) @ turn / size
        rays[:, 3:] = directions @ turn / size
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
        depth = hits["t_hit"].numpy()
        there = np.isfinite(depth)
        normals, colour = np.zeros((2, len(rays), 3), np.float32)
        across = hits["primitive_normals"].numpy()[there] / size @ turn.T
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        normals[there] = across * -np.sign((across * directions[there]).sum(axis=1, keepdims=True))
        colour[there] = self._colours[hits["primitive_ids"].numpy()[there]]
        return Seen(np.where(there, depth, 0).astype(np.float32), normals, colour)


def colour_of(visual: Visual) -> tuple[float, float, float]:
    """The colour of a visual; the mean of its texture, if it has one."""
    if visual.colour is not None:
        return visual.colour[:3]
    return UNPAINTED
