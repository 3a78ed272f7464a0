"""Read masks with labels: by the file's kind, JSON of several tools, and label images."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.categories import category_in, known_categories
from roomkin.stages.contracts.category import find_category
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.images import read_masks, read_upright
from roomkin.stages.perception.read.depth_files import ARRAYS, read_array
from roomkin.stages.perception.read.frame import Labelled, surface_of
from roomkin.stages.perception.read.mask_json import read_coco, read_labelme
from roomkin.stages.perception.read.mask_outlines import (
    NAMES_OPTION,
    OUTLINES,
    choose_named,
    read_folder,
    read_names,
    read_yolo,
)
from roomkin.stages.perception.read.mask_shapes import NO_PIXELS, check_size, lay_shapes, list_remarks

OWN_NAMES = ("class_name", "category_name", "label", "phrase")  # of an annotation, in the place of a category's number
SIZES = ("img_width", "img_height", "image_width", "image_height", "width", "height")
EXPORT = "export COCO or labelme JSON, or a label image as PNG"
MAX_VALUES = 1000  # of a label image; a photograph has more; chosen
ARRAY = "store one array (height, width) of whole numbers"


def read_labelled(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    """Masks of a picture of this size. Prints how many of what the file shows are used, and why others are not.

    Args:
        path: COCO, labelme, Grounded-SAM-2 or segment-anything JSON, YOLO's text, a folder of outlines, a PNG or an
            array.
        labels: names of the numbers of all but the first three, which have their own.
        picture: its file name, by which a COCO file of many pictures knows it.

    Raises:
        InputError: nothing of the kind, masks of another size, a shape that cannot be read, or none at all.
    """
    if path.is_dir():
        masks = read_folder(path, labels, width, height)
    elif path.suffix.lower() == ".json":
        masks = _read_json(path, labels, width, height, picture)
    elif path.suffix.lower() == ".txt":
        masks = read_yolo(path, labels, width, height)
    else:
        masks = read_label_image(path, labels, width, height)
    if nothing := [(label, "is nothing to place") for label in masks.labels.values() if surface_of(label) == "nothing"]:
        print(f"{path}: left out: {list_remarks(nothing)}")
    return translate_labels(path, masks)


def translate_labels(path: Path, masks: Labelled) -> Labelled:
    """Masks whose names of things in other languages are those of our categories. Prints them."""
    categories = known_categories()
    strange = {label for label in masks.labels.values() if not (surface_of(label) or find_category(label, categories))}
    meant = {label: category for label in sorted(strange) if (category := category_in(label))}
    if meant:
        print(f"{path}: names read as ours: {', '.join(f'{label}: {category}' for label, category in meant.items())}")
    return replace(masks, labels={number: meant.get(label, label) for number, label in masks.labels.items()})


def _read_json(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    with explain_unreadable(path, "JSON file", "export it again"):
        data = json.loads(decode_file(path))
    if _is_of_values(data):
        return _read_beside(path, width, height)
    items = _list_items(data)
    if items and not any(key in item for item in items for key in (*OWN_NAMES, "category_id", "segments_info")):
        data = _name_items(path, data, items, labels)
    elif labels is not None:
        print(f"{labels}: not read, {path.name} has names of its own")
    data = _as_coco(data)
    keys = set(data) if isinstance(data, dict) else set()
    if {"annotations", "categories"} <= keys and not _is_panoptic(data["annotations"]):
        return lay_shapes(path, read_coco(path, data, width, height, picture), "annotations")
    if "shapes" in keys:
        return lay_shapes(path, read_labelme(path, data, width, height, picture), "shapes")
    what = "is neither COCO with annotations and categories, nor labelme with shapes, nor Grounded-SAM-2's annotations."
    raise InputError(path, what, EXPORT, code="E-MASKS-FORMAT")


def _list_items(data: Any) -> list[dict[str, Any]]:
    """The annotations with outlines that a file has, alone or under that name; none if it has others."""
    items = data.get("annotations") if isinstance(data, dict) else data
    outlined = isinstance(items, list) and all(isinstance(one, dict) and "segmentation" in one for one in items)
    return items if outlined and isinstance(items, list) else []


def _name_items(path: Path, data: Any, items: list[dict[str, Any]], labels: Path | None) -> dict[str, Any]:
    """What segment-anything writes, outlines without names, with those that a file has for their numbers."""
    names = {} if labels is None else read_names(labels)[0]
    known = choose_named(path, {k: str(k) for k in range(len(items))}, labels, names, "outlines", OUTLINES)
    about = data.get("image") if isinstance(data, dict) else None
    return {**(about or {}), "annotations": [{**items[k], "label": names[k]} for k in known]}


def _as_coco(data: Any) -> Any:
    """Annotations that have their names themselves (Grounded-SAM-2's results) as COCO's; all else as it is."""
    items = _list_items(data)
    name = next((key for key in OWN_NAMES if all(isinstance(item.get(key), str) for item in items)), None)
    if name is None or not items:
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


def _is_of_values(data: Any) -> bool:
    """Whether a file has the names of the values of a picture, as Grounded-Segment-Anything's mask.json."""
    items = data.get("mask") if isinstance(data, dict) else data
    return isinstance(items, list) and bool(items) and all(isinstance(one, dict) and "value" in one for one in items)


def _read_beside(names: Path, width: int, height: int) -> Labelled:
    """Masks of the picture of values that lies beside its names.

    Raises:
        InputError: there is none.
    """
    if (values := names.with_suffix(".png")).is_file():
        print(f"{names}: has the names of {values.name}")
        return read_label_image(values, names, width, height)
    what = f"has names and boxes, and no {values.name} beside it has the outlines; a {names.stem}.jpg is a drawing."
    mend = f'cv2.imwrite("{values.name}", mask_img.numpy().astype("uint8")) where the script draws mask_img'
    raise InputError(names, what, mend, code="E-MASKS-FORMAT")


def read_label_image(path: Path, labels: Path | None, width: int, height: int) -> Labelled:
    """Masks of a picture of this size. Prints the values without a name, and the names without a pixel.

    Raises:
        InputError: no label image, one of another size, or names that are not those of its values.
    """
    names, colored = ({}, False) if labels is None else read_names(labels)
    shown, colors = _read_values(path, colored)
    check_size(path, (shown.shape[1], shown.shape[0]), width, height)
    found, pixels = np.unique(shown[shown > 0], return_counts=True)
    if len(found) > MAX_VALUES:
        what = f"has {len(found):,} different values: a photograph, not masks."
        raise InputError(path, what, "COCO or labelme JSON, or a label image as PNG", code="E-MASKS-FORMAT")
    if names.get(0) and surface_of(names[0]) != "nothing" and not shown.all():
        what = f"calls the value {_write_value(0, colors)} {names[0]!r}, which is the value of what nobody outlined."
        raise InputError(labels, what, "count objects from 1", code="E-MASKS-NAMES")
    sizes = dict(zip(found.tolist(), pixels.tolist(), strict=True))
    told = {value: f"{_write_value(value, colors)} ({number} pixels)" for value, number in sizes.items()}
    known = choose_named(path, told, labels, names, "values", NAMES_OPTION)
    if absent := [(name, NO_PIXELS) for value, name in names.items() if value and value not in sizes]:
        print(f"{path}: {len(absent) + len(known)} names, {len(known)} used: {list_remarks(absent)}")
    renumbered = colors or max(known) > np.iinfo(np.uint16).max
    numbers = {value: number if renumbered else value for number, value in enumerate(known, 1)}
    result = np.zeros(shown.shape, dtype=np.uint16)
    for value, number in numbers.items():
        result[shown == value] = number
    return Labelled(result, {numbers[value]: names[value] for value in known})


def _read_values(path: Path, colored: bool) -> tuple[NDArray[Any], bool]:
    """Values (H, W), and whether they are colors: of a palette only if names are those of colors."""
    if path.suffix.lower() in ARRAYS:
        return _read_numbers(path), False
    with explain_unreadable(path, "picture"):
        image = read_upright(path)
    if image.mode not in ("RGB", "RGBA") and not (colored and image.mode == "P"):
        return read_masks(path), False
    if image.format in ("JPEG", "MPO"):
        raise InputError(path, "is a JPEG, which changes mask values.", "save masks as PNG", code="E-MASKS-FORMAT")
    red, green, blue, alpha = np.moveaxis(np.asarray(image.convert("RGBA"), dtype=np.int64), -1, 0)
    if not colored and (red == green).all() and (red == blue).all():
        return np.where(alpha > 0, red, 0), False  # indices that were saved in colors
    return np.where(alpha > 0, (red << 16) + (green << 8) + blue, 0), True


def _read_numbers(path: Path) -> NDArray[Any]:
    """Values (H, W) of an array.

    Raises:
        InputError: it is no picture of whole numbers.
    """
    with explain_unreadable(path, "array", ARRAY):
        array = read_array(path, "masks")
    if array.ndim != 2 or array.dtype.kind not in "biuf" or (array.dtype.kind == "f" and (array % 1 != 0).any()):
        what = f"has shape {array.shape} and type {array.dtype}: it is no label image."
        raise InputError(path, what, ARRAY, code="E-MASKS-FORMAT")
    return array.astype(np.int64)


def _write_value(value: int, color: bool) -> str:
    return f"#{value:06x}" if color else str(value)
