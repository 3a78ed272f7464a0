"""Read masks with labels: COCO and labelme JSON, and label images in colours or indices with a file of names."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stages.contracts import InputError
from stages.contracts.arrays import readable
from stages.contracts.images import read_masks
from stages.geometry.masks import polygon
from stages.inputs.rgbd.frame import Labelled

MOST = 1000  # values of a label image; a photograph has more
NAMES = '--labels with {"1": "mug", "2": "floor"}, or {"#ff0000": "mug"} for a picture in colours'

Masks = list[tuple[str, NDArray[np.bool_]]]  # label and pixels of each object


def read_labelled(path: Path, labels: Path | None, width: int, height: int, picture: str) -> Labelled:
    """Masks of a picture of this size.

    Args:
        path: COCO or labelme JSON, or a PNG.
        labels: names of the PNG's values or colours, as JSON; not for JSON, which has its own.
        width: of the picture that the masks are of.
        height: of it.
        picture: its file name, by which a COCO file of many pictures knows it.

    Raises:
        InputError: nothing of the kind, masks of another size, or none at all.
    """
    if path.suffix.lower() != ".json":
        return _from_image(path, labels, width, height)
    with readable(path, "JSON file"):
        data = json.loads(path.read_text(encoding="utf-8"))
    if isinstance(data, dict) and "annotations" in data and "categories" in data:
        masks = _from_coco(path, data, width, height, picture)
    elif isinstance(data, dict) and "shapes" in data:
        masks = _from_labelme(path, data, width, height)
    else:
        raise InputError(
            path,
            "is neither COCO (annotations, categories) nor labelme (shapes).",
            "COCO or labelme JSON, or a label image as PNG",
            code="E-MASKS-FORMAT",
        )
    return stacked(path, masks)


def stacked(path: Path, masks: Masks) -> Labelled:
    """Masks in one label image; where they overlap the smaller one lies on top.

    Raises:
        InputError: there is none.
    """
    masks = [(label, mask) for label, mask in masks if mask.any()]
    if not masks:
        raise InputError(path, "shows no object in this picture.", "masks of this very picture", code="E-MASKS-EMPTY")
    values = np.zeros(masks[0][1].shape, dtype=np.uint16)
    for number in sorted(range(len(masks)), key=lambda k: -int(masks[k][1].sum())):
        values[masks[number][1]] = number + 1
    return Labelled(values, {number: label for number, (label, _) in enumerate(masks, 1)})


def _from_coco(path: Path, data: dict[str, Any], width: int, height: int, picture: str) -> Masks:
    with readable(path, "COCO file"):
        names = {category["id"]: str(category["name"]) for category in data["categories"]}
        images = data.get("images", [])
        mine = [image for image in images if Path(str(image.get("file_name", ""))).name == picture]
        if not mine and len(images) > 1:
            known = ", ".join(str(image.get("file_name")) for image in images[:5])
            raise InputError(
                path,
                f"has no picture called {picture}, but {known}, ...",
                "rename the picture, or give a file of it alone",
                code="E-MASKS-PICTURE",
            )
        image = (mine or images or [{}])[0]
        size = int(image.get("width", width)), int(image.get("height", height))
        _check_size(path, size, width, height)
        items = [item for item in data["annotations"] if item.get("image_id") == image.get("id")]
        return [(names[item["category_id"]], _coco_mask(item["segmentation"], width, height)) for item in items]


def _coco_mask(segmentation: Any, width: int, height: int) -> NDArray[np.bool_]:
    if isinstance(segmentation, dict):
        counts = segmentation["counts"]
        runs = _run_lengths(counts) if isinstance(counts, str) else [int(count) for count in counts]
        if sum(runs) != width * height or min(runs, default=0) < 0:
            raise ValueError("a run-length mask of another size")
        bits = np.repeat(np.arange(len(runs)) % 2, runs).astype(bool)
        return np.asarray(bits.reshape(width, height).T)  # column by column
    mask = np.zeros((height, width), dtype=bool)
    for points in segmentation:
        mask |= polygon(points, (height, width))
    return mask


def _run_lengths(text: str) -> list[int]:
    """COCO's compressed run lengths: five bits a character, least first; from the third on less the last but one."""
    runs: list[int] = []
    position = 0
    while position < len(text):
        value, shift, more = 0, 0, True
        while more:
            bits = ord(text[position]) - 48
            value |= (bits & 31) << shift
            position, shift, more = position + 1, shift + 5, bool(bits & 32)
            if not more and bits & 16:
                value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
    return runs


def _from_labelme(path: Path, data: dict[str, Any], width: int, height: int) -> Masks:
    with readable(path, "labelme file"):
        _check_size(path, (int(data.get("imageWidth") or width), int(data.get("imageHeight") or height)), width, height)
        masks: dict[tuple[str, object], NDArray[np.bool_]] = {}
        for number, shape in enumerate(data["shapes"]):
            points, kind = np.asarray(shape["points"], dtype=float), shape.get("shape_type") or "polygon"
            if kind == "rectangle":
                (left, top), (right, bottom) = points
                points = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
            elif kind == "circle":
                angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
                radius = np.linalg.norm(points[1] - points[0])
                points = points[0] + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
            elif kind != "polygon":
                continue  # points and lines are no masks
            group = shape.get("group_id")
            key = str(shape["label"]), number if group is None else f"group {group}"
            mask = polygon(points, (height, width))
            masks[key] = mask | masks[key] if key in masks else mask
        return [(label, mask) for (label, _), mask in masks.items()]


def _from_image(path: Path, labels: Path | None, width: int, height: int) -> Labelled:
    with readable(path, "picture"), Image.open(path) as image:
        colours = image.mode in ("RGB", "RGBA")
        if colours and image.format == "JPEG":
            raise InputError(path, "is a JPEG, which changes mask values.", "save masks as PNG", code="E-MASKS-FORMAT")
        picture = np.asarray(image.convert("RGB")) if colours else None
    values = read_masks(path) if picture is None else None
    shown: NDArray[Any] = values if picture is None else _packed(picture)  # type: ignore[assignment]
    _check_size(path, (shown.shape[1], shown.shape[0]), width, height)
    found = [int(value) for value in np.unique(shown) if value]
    if len(found) > MOST:
        raise InputError(
            path,
            f"has {len(found):,} different values: a photograph, not masks.",
            "COCO or labelme JSON, or a label image as PNG",
            code="E-MASKS-FORMAT",
        )
    if labels is None:
        raise InputError(path, f"has {len(found)} values without names.", NAMES, code="E-MASKS-NAMES")
    names = _read_names(labels)
    known = {value: names[value] for value in found if value in names}
    if not known:
        first = ", ".join(_written(value, colours) for value in found[:5]) or "nothing"
        raise InputError(labels, f"names none of the values of {path}: {first}.", NAMES, code="E-MASKS-NAMES")
    if missing := [value for value in found if value not in known]:
        print(f"{path}: without a name, left out: {', '.join(_written(value, colours) for value in missing[:8])}")
    numbers = {value: number for number, value in enumerate(known, 1)} if colours else {value: value for value in known}
    result = np.zeros(shown.shape, dtype=np.uint16)
    for value, number in numbers.items():
        result[shown == value] = number
    return Labelled(result, {numbers[value]: label for value, label in known.items()})


def _packed(picture: NDArray[np.uint8]) -> NDArray[np.int64]:
    red, green, blue = np.moveaxis(picture.astype(np.int64), -1, 0)
    return (red << 16) + (green << 8) + blue


def _written(value: int, colour: bool) -> str:
    return f"#{value:06x}" if colour else str(value)


def _read_names(path: Path) -> dict[int, str]:
    with readable(path, "JSON file of names", NAMES):
        data = json.loads(path.read_text(encoding="utf-8"))
        names = {int(key[1:], 16) if key.startswith("#") else int(key): value for key, value in data.items()}
        if not all(isinstance(name, str) and name.strip() for name in names.values()):
            raise InputError(path, "has values that are no names.", NAMES, code="E-MASKS-NAMES")
        return names


def _check_size(path: Path, found: tuple[int, int], width: int, height: int) -> None:
    if found != (width, height):
        raise InputError(
            path,
            f"is of {found[0]}x{found[1]} pixels, but the picture has {width}x{height}.",
            "masks of this very picture",
            code="E-MASKS-SIZE",
        )
