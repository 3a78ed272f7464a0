"""Models of the library in a unit box, and what rays see of them: a ray caster needs no Vulkan, and a few ms."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from stages.articulated.asset_folder import read_asset, urdf_of
from stages.articulated.forward_kinematics import frames_of
from stages.articulated.mesh_reader import texture_of
from stages.articulated.model import Visual
from stages.articulated.urdf_reader import UrdfReader
from stages.contracts.errors import InputError
from stages.contracts.library import Asset
from stages.contracts.look import GAMMA
from stages.generation.solid import find_outermost
from stages.geometry.boxes import UprightBox
from stages.geometry.frames import transform_points, yaw_matrix

UNPAINTED = (0.6, 0.6, 0.6)  # linear; chosen
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Seen:
    """What rays (N,) see: depth in units of their directions (0: nothing), unit normals (N, 3) in the frame around the
    box, towards the eye, and colours (N, 3), linear: of the surface, and with every texture evened out to its mean."""

    depth: NDArray[np.float32]
    normals: NDArray[np.float32]
    colour: NDArray[np.float32]
    plain: NDArray[np.float32]


class Solid:
    """The visible surface of an asset, every joint closed, scaled so that its box is [-0.5, 0.5]^3.

    A box in a scene is an affine map of the unit box, so rays are mapped, never the triangles.
    """

    def __init__(self, folder: Path) -> None:
        self.asset: Asset = read_asset(folder)
        reader = UrdfReader(urdf_of(folder, self.asset), folder)
        frames = frames_of(reader.tree.root, reader.joints)
        pieces = [(frames[name], visual) for name in reader.tree.links for visual in reader.visuals(name)]
        if reader.remarks:
            raise InputError(reader.path, reader.remarks[0], code="E-MODEL-BROKEN")
        low, size = np.array(self.asset.box_min), np.maximum(self.asset.size, 1e-6)
        points = [(transform_points(frame, visual.mesh.vertices) - low) / size - 0.5 for frame, visual in pieces]
        faces = [np.asarray(visual.mesh.faces) for _, visual in pieces]
        starts = np.cumsum([0, *map(len, points[:-1])])
        vertices = np.concatenate(points)
        self.outermost = find_outermost(vertices)
        triangles = np.concatenate([face + start for face, start in zip(faces, starts, strict=True)])
        self._piece = np.repeat(np.arange(len(pieces)), [len(face) for face in faces])
        self._looks = [looks_of(visual) for _, visual in pieces]
        self._plain = np.array([looks.image.mean(axis=(0, 1)) for looks in self._looks])
        uvs = [looks.uv[face] for looks, face in zip(self._looks, faces, strict=True)]
        self._uv = np.concatenate(uvs)
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(
            o3d.core.Tensor.from_numpy(vertices.astype(np.float32)),
            o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
        )

    def place_outline(self, box: UprightBox) -> Array:
        """Its outermost vertices (N, 3) when its box is `box`."""
        return self.outermost * box.size @ yaw_matrix(box.yaw).T + box.center

    def look(self, origin: Array, directions: Array, box: UprightBox) -> Seen:
        """What rays from `origin` (3,) along `directions` (N, 3) see of it in the box; nobody is inside the box."""
        turn, size = yaw_matrix(box.yaw), box.size
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3] = (origin - box.center) @ turn / size
        rays[:, 3:] = directions @ turn / size
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
        depth = hits["t_hit"].numpy()
        there = np.isfinite(depth)
        normals, colour, plain = np.zeros((3, len(rays), 3), np.float32)
        across = hits["primitive_normals"].numpy()[there] / size @ turn.T
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        normals[there] = across * -np.sign((across * directions[there]).sum(axis=1, keepdims=True))
        triangles = hits["primitive_ids"].numpy()[there]
        colour[there] = self._colours(triangles, hits["primitive_uvs"].numpy()[there])
        plain[there] = self._plain[self._piece[triangles]]
        return Seen(np.where(there, depth, 0).astype(np.float32), normals, colour, plain)

    def _colours(self, triangles: NDArray[np.integer], at: NDArray[np.float32]) -> NDArray[np.float32]:
        """Colours (N, 3) of triangles at barycentric coordinates (N, 2) of their second and third corner."""
        corners = np.stack([1 - at.sum(axis=1), at[:, 0], at[:, 1]], axis=1)
        uv = (self._uv[triangles] * corners[..., None]).sum(axis=1)
        pieces, colours = self._piece[triangles], np.empty((len(triangles), 3), np.float32)
        for piece in np.unique(pieces):
            own, image = pieces == piece, self._looks[piece].image
            height, width = image.shape[:2]
            columns, rows = np.floor(uv[own, 0] * width).astype(int), np.floor(-uv[own, 1] * height).astype(int)
            colours[own] = image[rows % height, columns % width]
        return colours


class Looks(NamedTuple):
    """A picture (H, W, 3), linear, one pixel for a plain colour, and texture coordinates (V, 2) of the vertices."""

    image: NDArray[np.float32]
    uv: NDArray[np.float32]


def looks_of(visual: Visual) -> Looks:
    """Texture or colour of a visual."""
    picture = texture_of(visual.mesh) if visual.colour is None else None
    uv = getattr(visual.mesh.visual, "uv", None)
    if picture is not None and uv is not None:
        encoded = np.asarray(picture.convert("RGB"), np.float32) / 255
        return Looks((encoded**GAMMA).astype(np.float32), np.asarray(uv, np.float32))
    colour = UNPAINTED if visual.colour is None else visual.colour[:3]
    return Looks(np.array(colour, np.float32)[None, None], np.zeros((len(visual.mesh.vertices), 2), np.float32))
