"""A room of boxes, ray-traced in numpy: the input folder of `extraction` with a known answer."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import Annotations, Camera, write_json
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at, yaw_matrix

WIDTH, HEIGHT = 480, 360
FLOOR, WALL, OBJECT = 1, 2, 10  # mask values; objects count up from OBJECT
BACK_WALL = 4.0  # the wall is the plane x = BACK_WALL; the camera looks along +x
INTRINSICS = intrinsics_from_fov(WIDTH, HEIGHT, np.deg2rad(55))
WORLD_FROM_CAMERA = look_at([0.0, 0.0, 1.6], [3.0, 0.1, 0.7])


def hit_box(origin: NDArray, rays: NDArray, box: UprightBox) -> NDArray:
    """Distance along each ray to the box, inf if it misses."""
    turn = yaw_matrix(box.yaw)
    start, direction = (origin - np.asarray(box.center)) @ turn, rays @ turn
    with np.errstate(divide="ignore"):
        sides = (np.array([[-0.5], [0.5]]) * box.size - start)[:, None, None] / direction[None]
    enter, leave = sides.min(axis=0).max(axis=-1), sides.max(axis=0).min(axis=-1)
    return np.where((enter < leave) & (enter > 0), enter, np.inf)


def trace(boxes: list[UprightBox], wall: bool = True) -> tuple[NDArray, NDArray]:
    """Depth (H, W) float32 along the optical axis and masks (H, W) uint16."""
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    in_camera = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(INTRINSICS).T  # z = 1, so t is depth
    rays, origin = in_camera @ WORLD_FROM_CAMERA[:3, :3].T, WORLD_FROM_CAMERA[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        floor = np.where(rays[..., 2] < 0, -origin[2] / rays[..., 2], np.inf)
        back = np.where(rays[..., 0] > 0, (BACK_WALL - origin[0]) / rays[..., 0], np.inf)
    layers = [floor, back if wall else np.full_like(back, np.inf)] + [hit_box(origin, rays, box) for box in boxes]
    values = np.array([FLOOR, WALL] + [OBJECT + k for k in range(len(boxes))], dtype=np.uint16)
    nearest = np.argmin(layers, axis=0)
    depth = np.min(layers, axis=0)
    seen = depth < 15
    return np.where(seen, depth, 0).astype(np.float32), np.where(seen, values[nearest], 0).astype(np.uint16)


def write_room(folder: Path, boxes: list[UprightBox], labels: list[str], wall: bool = True, floor: bool = True) -> Path:
    """Write the input folder of a room; objects get mask values OBJECT, OBJECT + 1, ..."""
    depth, masks = trace(boxes, wall)
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "rgb.png"), np.dstack([masks * 20 % 255] * 3).astype(np.uint8))
    cv2.imwrite(str(folder / "masks.png"), masks)
    np.savez_compressed(folder / "depth.npz", depth=depth, exact=True)
    write_json(folder / "camera.json", Camera(width=WIDTH, height=HEIGHT, intrinsics=INTRINSICS.tolist()))
    objects = [Annotation(mask=OBJECT + k, label=label) for k, label in enumerate(labels)]
    write_json(
        folder / "annotations.json",
        Annotations(objects=objects, floor=FLOOR if floor else None, walls=[WALL] if wall else []),
    )
    return folder
