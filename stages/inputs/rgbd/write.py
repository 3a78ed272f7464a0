"""An RGB-D frame as an input folder: rgb.png, camera.json, depth.npz; with masks masks.png and annotations.json."""

import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.config.own_scene import write_config
from stages.contracts import Annotations, Camera, InputError
from stages.contracts.scene_input import write_scene_input
from stages.contracts.scenes import Annotation
from stages.inputs.rgbd.cameras import resized
from stages.inputs.rgbd.clusters import TILT
from stages.inputs.rgbd.frame import LONGEST, Frame, Labelled, is_nothing, is_stretched

LONGEST_LABEL = 200  # characters
TRIM = 0.005  # of a thing's points left out at either end: strays are fewer than in estimated depth
FLOOR, WALL = {"floor", "ground", "carpet"}, {"wall", "walls"}
OPENS = {
    "cabinet", "cabinets", "chest", "closet", "cupboard", "dishwasher", "drawer", "drawers", "dresser", "fridge",
    "microwave", "nightstand", "oven", "refrigerator", "sideboard", "wardrobe",
}  # fmt: skip


def fitted(frame: Frame) -> Frame:
    """The frame at one size, at most `LONGEST` pixels: depth and masks laid on the picture's pixels.

    Raises:
        InputError: depth has other proportions than the picture, so that it is of another view.
    """
    height, width = frame.rgb.shape[:2]
    if is_stretched(frame.depth.shape[::-1], (width, height)):
        what = f"is {frame.depth.shape[1]}x{frame.depth.shape[0]}, the picture {width}x{height}: other proportions."
        raise InputError(
            "depth", what, "align depth to the colour picture first (every camera's software does)", code="E-DEPTH-SIZE"
        )
    shrunk = max(1.0, max(width, height) / LONGEST)
    size = round(width / shrunk), round(height / shrunk)
    masks = frame.masks and Labelled(_nearest(frame.masks.values, size), frame.masks.labels)
    rgb = frame.rgb if shrunk == 1 else np.asarray(cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA))
    intrinsics = resized(frame.intrinsics, size[0] / width, size[1] / height)
    depth = _nearest(frame.depth, size)
    return replace(frame, rgb=rgb.astype(np.uint8), depth=depth, intrinsics=intrinsics, masks=masks)


def _nearest(array: NDArray, size: tuple[int, int]) -> NDArray:  # type: ignore[type-arg]
    return np.asarray(cv2.resize(array, size, interpolation=cv2.INTER_NEAREST_EXACT), dtype=array.dtype)


def annotated(masks: Labelled) -> tuple[NDArray[np.uint16], Annotations]:
    """masks.png and annotations.json; floor and walls are told by their names, all floors are one.

    Raises:
        InputError: there is nothing but floor and walls, or a label is no word.
    """
    for label in masks.labels.values():
        if len(label) > LONGEST_LABEL or not label.isprintable():
            what = f"have the label {label[:40]!r}, which cannot be printed or is too long."
            raise InputError("masks", what, f"a word or two, at most {LONGEST_LABEL} characters", code="E-MASKS-NAMES")
    values = masks.values.copy()
    shown = set(np.unique(values).tolist())
    kinds = {value: label.strip().lower() for value, label in masks.labels.items() if value in shown}
    floors = [value for value, label in kinds.items() if label in FLOOR]
    values[np.isin(values, floors[1:])] = floors[0] if floors else 0
    values[np.isin(values, [value for value, label in kinds.items() if is_nothing(label)])] = 0
    objects = [
        Annotation(
            mask=value, label=masks.labels[value].strip(), articulated=bool(OPENS & set(re.split(r"\W+", label)))
        )
        for value, label in kinds.items()
        if label not in FLOOR | WALL and not is_nothing(label)
    ]
    if not objects:
        raise InputError(
            "masks", "show no object, only floor and walls.", "name at least one object", code="E-MASKS-EMPTY"
        )
    walls = [value for value, label in kinds.items() if label in WALL]
    return values, Annotations(objects=objects, floor=floors[0] if floors else None, walls=walls)


def write_frame(folder: Path, frame: Frame, doubt: str = "") -> Annotations | None:
    """Write the input folder, and `config.yaml` if it is whole; without masks the first three files alone.

    `doubt`: of the camera or its depth, for the scene's page.
    """
    frame = fitted(frame)
    height, width = frame.rgb.shape[:2]
    masks, annotations = (None, None) if frame.masks is None else annotated(frame.masks)
    camera = Camera(width=width, height=height, intrinsics=frame.intrinsics.tolist(), note=doubt)
    write_scene_input(folder, frame.rgb, frame.depth, camera, masks, annotations)
    if annotations is not None:
        # Depth is good up to the border, few points stray, and what is held in a hand looks down steeply.
        write_config(folder, extraction={"crop": 1.0, "trim": TRIM, "max_tilt": TILT})
    return annotations
