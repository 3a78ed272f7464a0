"""Label images: a value or a color for each object, with a file of names."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plugins.inputs.rgbd.frame import Labelled
from plugins.inputs.rgbd.mask_shapes import NO_PIXELS, check_size, list_remarks
from plugins.inputs.rgbd.surfaces import surface_of
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable
from stages.contracts.images import read_masks, read_upright

MAX_VALUES = 1000  # of a label image; a photograph has more; chosen
NAMES_OPTION = '--labels with {"1": "mug", "2": "floor"}, or {"#ff0000": "mug"} for a picture in colors'


def read_label_image(path: Path, labels: Path | None, width: int, height: int) -> Labelled:
    """Masks of a picture of this size. Prints the values without a name, and the names without a pixel.

    Raises:
        InputError: no label image, one of another size, or names that are not those of its values.
    """
    names, colored = ({}, False) if labels is None else _read_names(labels)
    shown, colors = _read_values(path, colored)
    check_size(path, (shown.shape[1], shown.shape[0]), width, height)
    found, pixels = np.unique(shown[shown > 0], return_counts=True)
    if len(found) > MAX_VALUES:
        raise InputError(
            path,
            f"has {len(found):,} different values: a photograph, not masks.",
            "COCO or labelme JSON, or a label image as PNG",
            code="E-MASKS-FORMAT",
        )
    if labels is None:
        raise InputError(path, f"has {len(found)} values without names.", NAMES_OPTION, code="E-MASKS-NAMES")
    if names.get(0) and surface_of(names[0]) != "nothing" and not shown.all():
        what = f"calls the value {_write_value(0, colors)} {names[0]!r}, which is the value of what nobody outlined."
        raise InputError(labels, what, "count objects from 1", code="E-MASKS-NAMES")
    sizes = dict(zip(found.tolist(), pixels.tolist(), strict=True))
    known = [value for value in sizes if value in names]
    if not known:
        first = ", ".join(_write_value(value, colors) for value in list(sizes)[:5]) or "nothing"
        raise InputError(labels, f"names none of the values of {path}: {first}.", NAMES_OPTION, code="E-MASKS-NAMES")
    nameless = [f"{_write_value(value, colors)} ({sizes[value]} pixels)" for value in sizes if value not in names]
    if nameless:
        more = f" and {len(nameless) - 8} more" if len(nameless) > 8 else ""
        print(f"{path}: without a name, left out: {', '.join(nameless[:8])}{more}")
    if absent := [(name, NO_PIXELS) for value, name in names.items() if value and value not in sizes]:
        print(f"{path}: {len(absent) + len(known)} names, {len(known)} used: {list_remarks(absent)}")
    numbers = {value: number for number, value in enumerate(known, 1)} if colors else {value: value for value in known}
    result = np.zeros(shown.shape, dtype=np.uint16)
    for value, number in numbers.items():
        result[shown == value] = number
    return Labelled(result, {numbers[value]: names[value] for value in known})


def _read_values(path: Path, colored: bool) -> tuple[NDArray[Any], bool]:
    """Values (H, W), and whether they are colors: of a palette only if names are those of colors."""
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


def _write_value(value: int, color: bool) -> str:
    return f"#{value:06x}" if color else str(value)


def _read_names(path: Path) -> tuple[dict[int, str], bool]:
    """Names of values, and whether those are colors."""
    with explain_unreadable(path, "JSON file of names", NAMES_OPTION):
        data = json.loads(path.read_text(encoding="utf-8"))
        names = {int(key[1:], 16) if key.startswith("#") else int(key): value for key, value in data.items()}
    if not all(isinstance(name, str) and name.strip() for name in names.values()):
        raise InputError(path, "has values that are no names.", NAMES_OPTION, code="E-MASKS-NAMES")
    return names, any(key.startswith("#") for key in data)
