"""A small library of ray-traced boxes with panels, their snapshots and a scene: no simulator needed."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import h5py
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import Cousins, Library, Objects, SnapshotShard, read_json, write_json
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at, yaw_matrix
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.features import run as features
from roomkin.stages.matching.match import run as match

SIZE, YAWS = 96, 16
ELEVATION = 0.3
# name: category, box (x, y, z), panel columns and rows on its front, doors, drawers
MODELS = {
    "bowl_00": ("bowl", (0.3, 0.3, 0.12), (1, 1), 0, 0),
    "bowl_01": ("bowl", (0.25, 0.25, 0.2), (1, 2), 0, 0),
    "cabinet_00": ("cabinet", (0.4, 0.9, 0.8), (2, 1), 2, 0),
    "cabinet_01": ("cabinet", (0.4, 0.5, 0.8), (1, 3), 0, 3),
    "cabinet_02": ("cabinet", (0.5, 0.6, 0.9), (1, 2), 1, 1),
    "cabinet_03": ("cabinet", (0.4, 1.2, 0.7), (3, 1), 3, 0),
    "cabinet_04": ("cabinet", (0.5, 0.6, 0.9), (2, 4), 0, 8),
    "shelf_00": ("shelf", (0.3, 0.8, 1.6), (1, 5), 0, 0),
}


def trace_box(
    size: tuple[float, float, float],
    yaw: float,
    panels: tuple[int, int],
    world_from_camera: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    width: int,
    height: int,
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Picture (H, W, 3) and depth (H, W; 0: nothing) of a box at the origin with panels on its front (+x)."""
    object_from_camera = yaw_matrix(-yaw) @ world_from_camera[:3, :3]
    eye = yaw_matrix(-yaw) @ world_from_camera[:3, 3]
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([u, v, np.ones_like(u)], -1) @ np.linalg.inv(intrinsics).T @ object_from_camera.T
    half = np.array(size) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        planes = np.stack([(-half - eye) / rays, (half - eye) / rays])
    near, far = planes.min(0), planes.max(0)
    depth = near.max(-1)
    seen = (depth <= far.min(-1)) & (depth > 0)
    face = near.argmax(-1)
    points = eye + rays * np.where(seen, depth, 0)[..., None]
    shade = np.choose(face, [150, 110, 190])
    across, up = (points[..., 1] / half[1] + 1) / 2 * panels[0], (points[..., 2] / half[2] + 1) / 2 * panels[1]
    edge = (np.abs(across % 1 - 0.5) > 0.44) | (np.abs(up % 1 - 0.5) > 0.44)
    front = (face == 0) & (points[..., 0] > 0)
    shade = np.where(front & edge, 60, shade)
    rgb = np.where(seen[..., None], shade[..., None], 210).astype(np.uint8).repeat(3, axis=-1)
    return rgb, np.where(seen, depth, 0).astype(np.float32)


def write_library(folder: Path, models: dict[str, tuple] = MODELS) -> Path:
    """library.json; returns its path."""
    entries = [
        LibraryEntry(
            id=name,
            category=model[0],
            archive="models.zip",
            doors=model[3],
            drawers=model[4],
            checksum=f"digest of {name}",
        )
        for name, model in sorted(models.items())
    ]
    write_json(folder / "library.json", Library(assets=entries))
    return folder / "library.json"


def write_snapshots(path: Path, names: list[str], models: dict[str, tuple] = MODELS) -> Path:
    """A shard with its sidecar; returns the .h5 path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    intrinsics = intrinsics_from_fov(SIZE, SIZE, 0.7)
    yaws = [2 * np.pi * k / YAWS for k in range(YAWS)]
    views = []
    for name in names:
        size = np.array(models[name][1]) / max(models[name][1])
        pose = look_at([2.4 * np.cos(ELEVATION), 0, 2.4 * np.sin(ELEVATION)], [0, 0, 0])
        views.append([trace_box(size, yaw, models[name][2], pose, intrinsics, SIZE, SIZE) for yaw in [*yaws, -0.5]])
    with h5py.File(path, "w") as file:
        file["rgb"] = np.array([[rgb for rgb, _ in asset] for asset in views])
        file["depth"] = np.array([[np.round(depth * 1000) for _, depth in asset] for asset in views], dtype=np.uint16)
    sidecar = SnapshotShard(
        assets=names,
        yaws=yaws,
        representative_yaw=-0.5,
        image_size=SIZE,
        intrinsics=intrinsics.tolist(),
        elevation=ELEVATION,
    )
    write_json(path.with_suffix(".json"), sidecar)
    return path


def write_scene(folder: Path, shown: list[tuple[str, float, dict]], models: dict[str, tuple] = MODELS) -> Path:
    """objects.json, masks.png, depth.npz and rgb.png with boxes side by side.

    `shown`: (model, yaw seen from the camera, fields of SceneObject that differ); returns objects.json.
    """
    folder.mkdir(parents=True, exist_ok=True)
    side, elevation = 128, 0.35
    intrinsics = intrinsics_from_fov(side, side, 0.6)
    tiles, items = [], []
    pose = look_at([3 * np.cos(elevation), 0, 3 * np.sin(elevation)], [0, 0, 0])
    for number, (name, yaw, fields) in enumerate(shown, 1):
        category, size, panels, doors, drawers = models[name]
        rgb, depth = trace_box(tuple(np.array(size) / max(size)), yaw, panels, pose, intrinsics, side, side)
        tiles.append((rgb, depth, np.where(depth > 0, number if fields.get("mask", number) == number else 0, 0)))
        base = {"id": f"{category}_{number}", "label": category, "mask": number, "doors": doors, "drawers": drawers}
        base |= {"box": Box(center=(0, 0, 0), size=size, yaw=0), "mounting": Mounting(type=2)}
        items.append(SceneObject(**(base | {"articulated": doors + drawers > 0} | fields)))
    margin = min(2, len(tiles) // 2)  # empty tiles: the camera of the first one is near the middle of the picture
    tiles = [tuple(np.zeros_like(part) for part in tiles[0])] * margin + tiles
    intrinsics[0, 2] += margin * side
    rgb, depth, masks = (np.concatenate([tile[k] for tile in tiles], axis=1) for k in range(3))
    cv2.imwrite(str(folder / "rgb.png"), rgb[..., ::-1])
    cv2.imwrite(str(folder / "masks.png"), masks.astype(np.uint16))
    np.savez(folder / "depth.npz", depth=depth)
    objects = Objects(
        scene="test",
        width=rgb.shape[1],
        height=side,
        intrinsics=intrinsics.tolist(),
        floor_from_camera=pose.tolist(),
        walls=[],
        objects=items,
    )
    write_json(folder / "objects.json", objects)
    return folder / "objects.json"


SHOWN: list[tuple[str, float, dict]] = [
    ("cabinet_00", 0.5, {}),
    ("cabinet_01", -0.4, {}),
    ("shelf_00", 0.9, {}),
    ("bowl_01", 0.2, {}),
    ("cabinet_02", 0.1, {"id": "lost_1", "status": "failed", "reason": "no points", "mask": 5}),
    ("bowl_00", 0.1, {"id": "unseen_1", "mask": 99}),
]


class World:
    """Files of one library and one scene; `options`: keys of `matching` that hold for all that is made. The models have
    pictures, no archive: distance judges."""

    def __init__(self, folder: Path, **options: Any) -> None:
        self.folder, self.options = (
            folder,
            {"model_selection": "distance", "orientation_selection": "distance"} | options,
        )
        encoding = json.dumps({key: options[key] for key in ("encoder", "kwargs", "dimensions") if key in options})
        self.library = write_library(folder)
        names = sorted(MODELS)
        self.snapshots = [write_snapshots(folder / f"shard_{k}.h5", names[k::2]) for k in range(2)]
        self.features = [folder / "features" / f"shard_{k}.npy" for k in range(2)]
        for snapshots, out in zip(self.snapshots, self.features, strict=True):
            features(snapshots=snapshots, out=out, options=encoding)
        self.objects = write_scene(folder / "scene", SHOWN)

    def match(self, out: Path, snapshots: Sequence[Path] = (), without: Sequence[Path] = (), **options: Any) -> Cousins:
        match(
            objects=self.objects,
            image=self.objects.parent / "rgb.png",
            library=self.library,
            features=self.features,
            out=out,
            snapshots=tuple(snapshots),
            without=tuple(without),
            options=json.dumps(self.options | options),
        )
        return read_json(Cousins, out)


def view_of_box(
    yaw: float, elevation: float = 0.3, distance: float = 3.0, offset: float = 0.0, side: int = 128
) -> ObjectView:
    intrinsics = intrinsics_from_fov(side, side, 0.8)
    eye = distance * np.array([np.cos(elevation), 0, np.sin(elevation)])
    pose = look_at(eye, [0, offset * distance, 0])
    rgb, depth = trace_box((0.6, 1.0, 0.8), yaw, (2, 1), pose, intrinsics, side, side)
    return ObjectView(rgb, depth > 0, depth, intrinsics, pose[:3, :3].T @ np.array([0.0, 0.0, 1.0]))


def before_noise(view: ObjectView) -> ObjectView:
    """The same object before a background of random colors."""
    noise = np.random.default_rng(0).integers(0, 255, view.rgb.shape, dtype=np.uint8)
    return replace(view, rgb=np.where(view.mask[..., None], view.rgb, noise))
