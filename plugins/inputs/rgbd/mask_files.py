"""Read masks with labels: COCO and labelme JSON, and label images."""

import json
from pathlib import Path
from typing import Any

from plugins.inputs.rgbd.frame import Labelled, is_nothing
from plugins.inputs.rgbd.mask_coco import read_coco
from plugins.inputs.rgbd.mask_images import read_label_image
from plugins.inputs.rgbd.mask_labelme import read_labelme
from plugins.inputs.rgbd.mask_shapes import lay_shapes, list_remarks
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable

EXPORT = "export COCO or labelme JSON, or a label image as PNG"


def read_labelled(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    """Masks of a picture of this size. Prints how many of what the file shows are used, and why others are not.

    Args:
        path: COCO or labelme JSON, or a PNG.
        labels: names of the PNG's values or colors, as JSON; not for JSON, which has its own.
        width: of the picture that the masks are of.
        height: of it.
        picture: its file name, by which a COCO file of many pictures knows it.

    Raises:
        InputError: nothing of the kind, masks of another size, a shape that cannot be read, or none at all.
    """
    if path.suffix.lower() != ".json":
        masks = read_label_image(path, labels, width, height)
    else:
        masks = _read_json(path, labels, width, height, picture)
    if nothing := [(label, "is nothing to place") for label in masks.labels.values() if is_nothing(label)]:
        print(f"{path}: left out: {list_remarks(nothing)}")
    return masks


def _read_json(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    if labels is not None:
        print(f"{labels}: not read, {path.name} has names of its own")
    with explain_unreadable(path, "JSON file"):
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    keys = set(data) if isinstance(data, dict) else set()
    if {"annotations", "categories"} <= keys and not _is_panoptic(data["annotations"]):
        return lay_shapes(path, read_coco(path, data, width, height, picture), "annotations")
    if "shapes" in keys:
        return lay_shapes(path, read_labelme(path, data, width, height, picture), "shapes")
    what = "is neither COCO with annotations and categories nor labelme with shapes."
    raise InputError(path, what, EXPORT, code="E-MASKS-FORMAT")


def _is_panoptic(items: Any) -> bool:
    """Whether COCO's masks are in another file."""
    return isinstance(items, list) and any(isinstance(item, dict) and "segments_info" in item for item in items)
