"""The output of extraction: objects.json with masks.png, depth.npz and clouds.npz beside it."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.arrays import check_array, check_within, read_npz
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.images import check_size, read_masks
from roomkin.stages.contracts.objects import Box, Objects
from roomkin.stages.contracts.types import FARTHEST
from roomkin.stages.geometry.frames import yaw_matrix

AGAIN = "extraction writes it beside objects.json"
BESIDE = 0.1  # metres by which half of a cloud may be outside its box
WITHIN = 0.1  # share of it that is no farther above: clutter on a table may show more points than the table
wrong_cloud = partial(InputError, fix=AGAIN, code="E-CLOUD-BROKEN")


def read_object_masks(path: Path, objects: Objects) -> NDArray[np.uint16]:
    """The masks (H, W) beside `path`, objects.json: the picture's size, and no value that no object has."""
    file = path.with_name("masks.png")
    masks = read_masks(file)
    check_size(file, masks, objects.width, objects.height, path.name)
    strangers = sorted(set(np.unique(masks).tolist()) - {0} - {item.mask for item in objects.objects})
    if strangers:
        what = f"holds the value {strangers[0]}, which no object of {path.name} has."
        raise InputError(file, what, AGAIN, code="E-MASK-VALUE")
    return masks


def read_metres(path: Path, objects: Objects) -> NDArray[np.float32] | None:
    """The depth (H, W) in metres beside `path`, objects.json; None without the file."""
    file = path.with_name("depth.npz")
    if not file.is_file():
        return None
    arrays = read_npz(file, AGAIN)
    if "depth" not in arrays:
        raise InputError(file, "has no array named 'depth'.", AGAIN, code="E-ARRAY-MISSING")
    depth: NDArray[Any] = arrays["depth"]
    check_array(file, "depth", depth, ("H", "W"))
    check_size(file, depth, objects.width, objects.height, path.name)
    check_within(file, "depth", depth, 0, FARTHEST)
    return depth.astype(np.float32)


def read_clouds(path: Path, objects: Objects) -> dict[str, NDArray[np.float32]]:
    """The clouds (N, 3) beside `path`, objects.json: one for each object that did not fail, in metres."""
    file = path.with_name("clouds.npz")
    clouds = read_npz(file, AGAIN)
    wanted = [item for item in objects.objects if item.status == "ok"]
    strangers = sorted(set(clouds) - {item.id for item in objects.objects})
    if strangers:
        raise wrong_cloud(file, f"holds a cloud of '{strangers[0]}', which is no object of {path.name}.")
    for item in wanted:
        if item.id not in clouds:
            raise wrong_cloud(file, f"has no cloud of '{item.id}'.")
        cloud = clouds[item.id]
        check_array(file, item.id, cloud, ("N", 3))
        if len(cloud) < 3:
            fix = "an object with fewer than 3 has failed"
            raise wrong_cloud(file, f"{item.id}: has {len(cloud)} points.", fix=fix)
        if item.points and item.points != len(cloud):
            raise wrong_cloud(file, f"{item.id}: has {len(cloud)} points, {path.name} says {item.points}.")
        check_within(file, item.id, cloud, -FARTHEST, FARTHEST)
        if item.box is not None and not item.whole and is_elsewhere(item.box, cloud):
            raise wrong_cloud(file, f"{item.id}: is not where its box of {path.name} is.")
    return {item.id: clouds[item.id].astype(np.float32) for item in wanted}


def is_elsewhere(box: Box, cloud: NDArray[np.floating]) -> bool:
    """Whether half of a cloud (N, 3) lies beside or below its box, or all but `WITHIN` of it above."""
    level = np.minimum(cloud, [np.inf, np.inf, box.center[2] + box.size[2] / 2])
    beside, outside = np.median(measure_outside(box, level)), np.quantile(measure_outside(box, cloud), WITHIN)
    return bool(max(beside, outside) > BESIDE)


def measure_outside(box: Box, cloud: NDArray[np.floating]) -> NDArray[np.float64]:
    """How far (N,) the points of a cloud (N, 3) are outside a box, along the axis where they are farthest; metres."""
    local = (cloud - np.asarray(box.center)) @ yaw_matrix(box.yaw)
    return np.asarray(np.abs(local) - np.asarray(box.size) / 2).max(axis=1)


def check_extracted(path: Path) -> None:
    """objects.json and all that lies beside it."""
    objects = read_json(Objects, path)
    read_object_masks(path, objects)
    read_metres(path, objects)
    read_clouds(path, objects)
