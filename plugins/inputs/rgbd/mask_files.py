"""Read masks with labels: COCO and labelme JSON, and label images; what other tools write is refused by its name."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from plugins.inputs.rgbd.frame import Labelled, is_nothing
from plugins.inputs.rgbd.mask_coco import read_coco
from plugins.inputs.rgbd.mask_images import read_label_image
from plugins.inputs.rgbd.mask_labelme import read_labelme
from plugins.inputs.rgbd.mask_shapes import lay_shapes, list_remarks
from plugins.inputs.rgbd.upright import Turn, turn_array
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable

EXPORT = "export COCO or labelme JSON, or a label image as PNG"
SUFFIXES = {  # what masks are that are no JSON and no picture
    ".xml": "XML, as CVAT or Pascal VOC write it",
    ".txt": "text, as YOLO writes it",
    ".csv": "a table",
    ".npy": "an array",
    ".npz": "arrays",
    ".h5": "HDF5",
    ".mat": "MATLAB's",
    ".zip": "an archive: unpack it",
    ".ndjson": "NDJSON, as Labelbox writes it",
    ".jsonl": "JSON lines",
    ".geojson": "GeoJSON",
}
OTHERS = (  # keys that tell who wrote a JSON file, of the whole or of its first entry
    ("masks of SAM, which have no names", {"predicted_iou"}),
    ("masks of SAM, which have no names", {"stability_score"}),
    ("COCO's results, which name no categories", {"image_id", "category_id"}),
    ("COCO's panoptic masks, which are in another file", {"segments_info"}),
    ("COCO without categories", {"images", "annotations"}),
    ("Datumaro's", {"items", "categories"}),
    ("VIA's", {"_via_img_metadata"}),
    ("VIA's", {"regions"}),
    ("Label Studio's", {"annotations", "data"}),
    ("Label Studio's", {"completions"}),
    ("Supervisely's", {"objects", "size"}),
    ("Cityscapes'", {"objects", "imgHeight"}),
    ("ISAT's", {"objects", "info"}),
    ("V7 Darwin's", {"item", "annotations"}),
    ("Labelbox's", {"data_row"}),
    ("CreateML's boxes", {"image", "annotations"}),
    ("GeoJSON", {"features"}),
    ("a file of names, which belongs to --labels", {"1"}),
)


def read_upright_masks(path: Path, labels: Path | None, turn: Turn) -> Labelled:
    """Masks of the size that the upright picture has, or, turned, of the one that the sensor wrote.

    Prints which are of nothing that can be placed.
    """
    try:
        masks = read_labelled(path, labels, turn.width, turn.height, turn.path.name)
    except InputError as error:
        if turn.orientation == 1 or error.code != "E-MASKS-SIZE":
            raise
        stored = read_labelled(path, labels, *turn.stored, turn.path.name)
        print(f"{path}: turned with its picture, whose EXIF data say so")
        masks = Labelled(turn_array(stored.values, turn.orientation), stored.labels)
    if nothing := [(label, "is nothing to place") for label in masks.labels.values() if is_nothing(label)]:
        print(f"{path}: left out: {list_remarks(nothing)}")
    return masks


def read_labelled(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    """Masks of a picture of this size. Prints how many of what the file shows are used, and why others are not.

    Args:
        path: COCO or labelme JSON, or a PNG.
        labels: names of the PNG's values or colours, as JSON; not for JSON, which has its own.
        width: of the picture that the masks are of.
        height: of it.
        picture: its file name, by which a COCO file of many pictures knows it.

    Raises:
        InputError: nothing of the kind, masks of another size, a shape that cannot be read, or none at all.
    """
    suffix = path.suffix.lower()
    if path.is_dir() or suffix in SUFFIXES:
        what = "a folder: one picture with a value for each object is read" if path.is_dir() else SUFFIXES[suffix]
        raise InputError(path, f"is {what}.", EXPORT, code="E-MASKS-FORMAT")
    if suffix != ".json":
        return read_label_image(path, labels, width, height)
    if labels is not None:
        print(f"{labels}: not read, {path.name} has names of its own")
    with explain_unreadable(path, "JSON file"):
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    read, kind = _choose_reader(path, data)
    return lay_shapes(path, read(path, data, width, height, picture), kind)


def _choose_reader(path: Path, data: Any) -> tuple[Callable[..., Any], str]:
    """What reads a JSON file, and what it calls its shapes.

    Raises:
        InputError: nothing does; the message names the tool that wrote it, if that is known.
    """
    keys = set(data) if isinstance(data, dict) else set()
    panoptic = _is_panoptic(data) if isinstance(data, dict) else False
    if {"annotations", "categories"} <= keys and not panoptic:
        return read_coco, "annotations"
    if "shapes" in keys:
        return read_labelme, "shapes"
    values = list(data.values()) if isinstance(data, dict) else data if isinstance(data, list) else []
    first = next((set(value) for value in values if isinstance(value, dict)), set())
    whose = next(
        (name for name, its_keys in OTHERS if its_keys <= keys or its_keys <= first), "neither COCO nor labelme"
    )
    whose = "COCO's panoptic masks, which are in another file" if panoptic else whose
    what = f"is {whose} (COCO has annotations and categories, labelme shapes)."
    raise InputError(path, what, EXPORT, code="E-MASKS-FORMAT")


def _is_panoptic(data: dict[str, Any]) -> bool:
    items = data.get("annotations")
    return isinstance(items, list) and any(isinstance(item, dict) and "segments_info" in item for item in items)
