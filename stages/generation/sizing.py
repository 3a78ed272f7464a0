"""Extents that the camera could not see, from the asset's own proportions. The paper has no such step (option off)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from stages.contracts.objects import Wall
from stages.generation.mounting import against_wall
from stages.geometry.boxes import UprightBox, volume
from stages.geometry.frames import wrap_angle, yaw_matrix


def sight_yaw(box: UprightBox, camera: ArrayLike) -> float:
    """Yaw whose x axis points away from the camera."""
    away = np.asarray(box.center, dtype=float)[:2] - np.asarray(camera, dtype=float)[:2]
    return wrap_angle(float(np.arctan2(away[1], away[0])))


def as_wide_as_seen(box: UprightBox, camera: ArrayLike, bearings: tuple[float, float]) -> UprightBox:
    """The box of a round asset, not narrower than its outline: few points lie at the outline, and they are trimmed.

    Args:
        box: measured along `sight_yaw`, so that y is width.
        bearings: level directions between which the object is seen, radians, floor frame.
    """
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    to_center = center[:2] - np.asarray(camera, dtype=float)[:2]
    distance, (low, high) = float(np.linalg.norm(to_center)), bearings
    width = 2 * distance * float(np.sin((high - low) / 2))
    if width <= size[1]:
        return box
    size[1] = width
    center[:2] += distance * yaw_matrix((low + high) / 2)[:2, 0] - to_center
    return UprightBox(center, size, box.yaw)


def round_box(box: UprightBox, believable: tuple[float, float]) -> UprightBox:
    """The box of a round asset: as deep as it is wide.

    Its width is seen whole; half of its surface is hidden, and noise and mixed pixels at its outline
    stretch the other half along the line of sight.

    Args:
        box: measured along `sight_yaw`, so that x is depth and y is width.
        believable: a depth beyond the second number times the width has points of the background in it.
    """
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    depth, width = size[:2]
    if depth < width or depth > believable[1] * width:
        center += (width - depth) / 2 * yaw_matrix(box.yaw)[:, 0]
    size[0] = width
    return UprightBox(center, size, box.yaw)


def told_box(box: UprightBox, yaw: float, walls: Sequence[Wall], min_extent: float) -> UprightBox:
    """A box that the input tells, with the axes of an asset at `yaw`, which run along its own; it ends at the walls."""
    center, size = np.array(box.center, dtype=float), np.array(box.size, dtype=float)
    if round((yaw - box.yaw) / (np.pi / 2)) % 2:
        size[:2] = size[1::-1]
    box = UprightBox(center, np.maximum(size, min_extent), yaw)
    for wall in walls:
        box = min(box, against_wall(box, wall, min_extent), key=volume)
    return box


def believable_box(
    box: UprightBox, native: ArrayLike, fixed_face: ArrayLike, believable: tuple[float, float]
) -> UprightBox:
    """The box with its depth replaced if it cannot be that of such an asset.

    The scale of an axis is its extent over the asset's native one. The median of the three scales is
    the asset's scale; a depth whose scale is outside `believable` times it gets that scale. Width and
    height are left alone: the picture shows them.

    Args:
        box: measured extents along the asset's axes.
        native: extents (3,) of the asset as it is in the library.
        fixed_face: direction (2,) to the face that stays where it is: towards the camera, since that
            side was seen, or towards the wall that the object touches. Depth is along it.
    """
    size, native = np.array(box.size, dtype=float), np.asarray(native, dtype=float)
    along = yaw_matrix(box.yaw)[:2, :2].T @ np.asarray(fixed_face, dtype=float)[:2]
    depth = int(np.argmax(np.abs(along)))
    scales = size / native
    scale = float(np.median(scales))
    if believable[0] * scale <= scales[depth] <= believable[1] * scale:
        return box
    growth = scale * native[depth] - size[depth]
    size[depth] += growth
    center = np.asarray(box.center, dtype=float)
    return UprightBox(center - np.sign(along[depth]) * growth / 2 * yaw_matrix(box.yaw)[:, depth], size, box.yaw)


def stretch(native: ArrayLike, box: UprightBox) -> float:
    """How far an asset is stretched in a box, 1 or more: as a whole, or one axis against another, whatever is more.

    A sofa of 2 m is no stool: it would be squeezed to a fifth of its width.
    """
    scales = np.asarray(box.size, dtype=float) / np.asarray(native, dtype=float)
    middle = float(np.median(scales))
    return max(float(scales.max() / scales.min()), middle, 1 / middle)
