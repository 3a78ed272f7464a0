"""Read masks with labels: COCO, labelme and Grounded-SAM-2 JSON, and label images."""

import json
from pathlib import Path
from typing import Any

from plugins.inputs.rgbd.frame import Labelled
from plugins.inputs.rgbd.mask_coco import read_coco
from plugins.inputs.rgbd.mask_images import read_label_image
from plugins.inputs.rgbd.mask_labelme import read_labelme
from plugins.inputs.rgbd.mask_shapes import lay_shapes, list_remarks
from plugins.inputs.rgbd.surfaces import surface_of
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable

OWN_NAMES = ("class_name", "category_name", "label", "phrase")  # of an annotation, in the place of a category's number
SIZES = ("img_width", "img_height", "image_width", "image_height", "width", "height")
EXPORT = "export COCO or labelme JSON, or a label image as PNG"


def read_labelled(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    """Masks of a picture of this size. Prints how many of what the file shows are used, and why others are not.

    Args:
        path: COCO, labelme or Grounded-SAM-2 JSON, or a PNG.
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
    if nothing := [(label, "is nothing to place") for label in masks.labels.values() if surface_of(label) == "nothing"]:
        print(f"{path}: left out: {list_remarks(nothing)}")
    return masks


def _read_json(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    if labels is not None:
        print(f"{labels}: not read, {path.name} has names of its own")
    with explain_unreadable(path, "JSON file"):
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    data = _as_coco(data)
    keys = set(data) if isinstance(data, dict) else set()
    if {"annotations", "categories"} <= keys and not _is_panoptic(data["annotations"]):
        return lay_shapes(path, read_coco(path, data, width, height, picture), "annotations")
    if "shapes" in keys:
        return lay_shapes(path, read_labelme(path, data, width, height, picture), "shapes")
    what = "is neither COCO with annotations and categories, nor labelme with shapes, nor Grounded-SAM-2's annotations."
    raise InputError(path, what, EXPORT, code="E-MASKS-FORMAT")


def _as_coco(data: Any) -> Any:
    """Annotations that have their names themselves (Grounded-SAM-2's results) as COCO's; all else as it is."""
    items = data if isinstance(data, list) else data.get("annotations") if isinstance(data, dict) else None
    if not isinstance(items, list) or not items or not all(isinstance(item, dict) for item in items):
        return data
    name = next((key for key in OWN_NAMES if all(isinstance(item.get(key), str) for item in items)), None)
    if name is None or "segmentation" not in items[0]:
        return data
    above = data if isinstance(data, dict) else {}
    size = {key.removeprefix("img_").removeprefix("image_"): above.get(key) for key in SIZES if above.get(key)}
    path = above.get("image_path") or above.get("file_name") or ""
    named = [{**item, "category_id": item[name].strip(" ."), "image_id": 0} for item in items]
    kinds = dict.fromkeys(item["category_id"] for item in named)
    images = [{"id": 0, "file_name": path, **size}]
    return {"annotations": named, "categories": [{"id": kind, "name": kind} for kind in kinds], "images": images}


def _is_panoptic(items: Any) -> bool:
    """Whether COCO's masks are in another file."""
    return isinstance(items, list) and any(isinstance(item, dict) and "segments_info" in item for item in items)
