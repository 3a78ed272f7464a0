"""A candidate in an object's place, rendered on the cells of the object's observation."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.render_and_compare.observation import Observation
from roomkin.plugins.render_and_compare.solid import ColoredSolid
from roomkin.stages.contracts.generated import GAMMA, ROOM_LIGHT
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.crop import View


@dataclass(frozen=True)
class Rendering:
    """A rendered candidate in each cell (h, w): color (h, w, 3) 0 to 1, the same without textures, the share
    that it covers, depth where it covers anything."""

    rgb: NDArray[np.float32]
    plain: NDArray[np.float32]
    cover: NDArray[np.float32]
    depth: NDArray[np.float32]

    def view(self, seen: Observation, up: NDArray[np.float64] | None) -> View:
        """The picture as a patch encoder takes it."""
        there = self.cover >= 0.5
        intrinsics = seen.intrinsics.copy()
        intrinsics[:2] /= seen.step
        intrinsics[:2, 2] = (seen.intrinsics[:2, 2] - seen.corner + 0.5) / seen.step - 0.5
        depth = np.where(there, self.depth, 0)
        return View((self.rgb * 255).round().astype(np.uint8), there, depth.astype(np.float32), intrinsics, up)


def render(solid: ColoredSolid, box: UprightBox, seen: Observation) -> Rendering:
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
