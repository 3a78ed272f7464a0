"""A model of the library with its textures, in an object's place, rendered on the cells of its observation."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from roomkin.plugins.render_and_compare.observation import ObservedGrid
from roomkin.stages.articulated.mesh_reader import texture_of
from roomkin.stages.articulated.model import Visual
from roomkin.stages.contracts.generated import GAMMA, ROOM_LIGHT
from roomkin.stages.generation.sizing import VisibleSolid
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import yaw_matrix
from roomkin.stages.geometry.masks import ObjectView

UNPAINTED = (0.6, 0.6, 0.6)  # linear; chosen
Array = NDArray[np.float64]


@dataclass(frozen=True)
class RayHits:
    """Hits of rays (N,): depth in units of their directions (0: nothing), unit normals (N, 3) in the frame around the
    box, towards the eye, and colors (N, 3), linear: of the surface, and with every texture evened out to its mean."""

    depth: NDArray[np.float32]
    normals: NDArray[np.float32]
    color: NDArray[np.float32]
    plain: NDArray[np.float32]


class ColoredSolid(VisibleSolid):
    """A solid with the texture of its surface."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        faces = [visual.mesh.faces for visual in self.visuals]
        self._piece = np.repeat(np.arange(len(faces)), list(map(len, faces)))
        self._textures = [read_texture(visual) for visual in self.visuals]
        self._plain = np.array([texture.image.mean(axis=(0, 1)) for texture in self._textures])
        self._uv = np.concatenate([texture.uv[face] for texture, face in zip(self._textures, faces, strict=True)])

    def place_outline(self, box: UprightBox) -> Array:
        """Its outermost vertices (N, 3) when its box is `box`."""
        return self.outermost * box.size @ yaw_matrix(box.yaw).T + box.center

    def cast_rays(self, origin: Array, directions: Array, box: UprightBox) -> RayHits:
        """What rays from `origin` (3,) along `directions` (N, 3) see of it in the box; nobody is inside the box."""
        turn, size = yaw_matrix(box.yaw), box.size
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3] = (origin - box.center) @ turn / size
        rays[:, 3:] = directions @ turn / size
        hits = self.scene.cast_rays(o3d.core.Tensor.from_numpy(rays), nthreads=1)
        depth = hits["t_hit"].numpy()
        there = np.isfinite(depth)
        normals, color, plain = np.zeros((3, len(rays), 3), np.float32)
        across = hits["primitive_normals"].numpy()[there] / size @ turn.T
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        normals[there] = across * -np.sign((across * directions[there]).sum(axis=1, keepdims=True))
        triangles = hits["primitive_ids"].numpy()[there]
        color[there] = self._colors(triangles, hits["primitive_uvs"].numpy()[there])
        plain[there] = self._plain[self._piece[triangles]]
        return RayHits(np.where(there, depth, 0).astype(np.float32), normals, color, plain)

    def _colors(self, triangles: NDArray[np.integer], at: NDArray[np.float32]) -> NDArray[np.float32]:
        """Colors (N, 3) of triangles at barycentric coordinates (N, 2) of their second and third corner."""
        corners = np.stack([1 - at.sum(axis=1), at[:, 0], at[:, 1]], axis=1)
        uv = (self._uv[triangles] * corners[..., None]).sum(axis=1)
        pieces, colors = self._piece[triangles], np.empty((len(triangles), 3), np.float32)
        for piece in np.unique(pieces):
            own, image = pieces == piece, self._textures[piece].image
            height, width = image.shape[:2]
            columns, rows = np.floor(uv[own, 0] * width).astype(int), np.floor(-uv[own, 1] * height).astype(int)
            colors[own] = image[rows % height, columns % width]
        return colors


class MappedTexture(NamedTuple):
    """A picture (H, W, 3), linear, one pixel for a plain color, and texture coordinates (V, 2) of the vertices."""

    image: NDArray[np.float32]
    uv: NDArray[np.float32]


def read_texture(visual: Visual) -> MappedTexture:
    """Texture or color of a visual."""
    picture = texture_of(visual.mesh) if visual.color is None else None
    uv = getattr(visual.mesh.visual, "uv", None)
    if picture is not None and uv is not None:
        encoded = np.asarray(picture.convert("RGB"), np.float32) / 255
        return MappedTexture((encoded**GAMMA).astype(np.float32), np.asarray(uv, np.float32))
    color = UNPAINTED if visual.color is None else visual.color[:3]
    return MappedTexture(np.array(color, np.float32)[None, None], np.zeros((len(visual.mesh.vertices), 2), np.float32))


@dataclass(frozen=True)
class Rendering:
    """A rendered candidate in each cell (h, w): color (h, w, 3) 0 to 1, the same without textures, the share
    that it covers, depth where it covers anything."""

    rgb: NDArray[np.float32]
    plain: NDArray[np.float32]
    cover: NDArray[np.float32]
    depth: NDArray[np.float32]

    def view(self, seen: ObservedGrid, up: NDArray[np.float64] | None) -> ObjectView:
        """The picture as a patch encoder takes it."""
        there = self.cover >= 0.5
        intrinsics = seen.intrinsics.copy()
        intrinsics[:2] /= seen.step
        intrinsics[:2, 2] = (seen.intrinsics[:2, 2] - seen.corner + 0.5) / seen.step - 0.5
        depth = np.where(there, self.depth, 0)
        return ObjectView((self.rgb * 255).round().astype(np.uint8), there, depth.astype(np.float32), intrinsics, up)


def render(solid: ColoredSolid, box: UprightBox, seen: ObservedGrid) -> Rendering:
    """Render a model in a box under one light; colors as in the model's materials."""
    hits = solid.cast_rays(seen.eye, seen.rays.reshape(-1, 3), box)
    lit = -hits.normals @ np.array(ROOM_LIGHT) / np.linalg.norm(ROOM_LIGHT)
    shade = (0.5 + np.clip(lit, 0, None) / 2)[:, None]
    there = (hits.depth > 0)[:, None]
    rgb, plain = (np.clip(color * shade, 0, 1) ** (1 / GAMMA) * there for color in (hits.color, hits.plain))

    def cells(values: NDArray[np.floating] | NDArray[np.bool_]) -> NDArray[np.float32]:
        """Means over the rays of each cell."""
        grid = values.astype(np.float32).reshape(*seen.rays.shape[:2], -1)
        means = cv2.resize(grid, seen.mask.shape[::-1], interpolation=cv2.INTER_AREA)
        return np.asarray(means.reshape(*seen.mask.shape, -1), np.float32)

    cover = cells(there)

    def seen_part(values: NDArray[np.floating]) -> NDArray[np.float32]:
        """Means over what it covers of each cell."""
        return np.asarray(cells(values) / np.maximum(cover, 1e-6), np.float32)

    return Rendering(seen_part(rgb), seen_part(plain), cover[..., 0], seen_part(hits.depth)[..., 0])
