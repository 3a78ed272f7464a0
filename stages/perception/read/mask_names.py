"""What the numbers of masks are called: a file of names, and which of the numbers have one."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.perception.read.camera_files import parse_yaml

NAMES_OPTION = '--labels with {"1": "mug", "2": "floor"}, or {"#ff0000": "mug"} for a picture in colors'
LISTED = 8  # numbers without a name that are told; chosen
# Where YOLO's data.yaml, Grounded-Segment-Anything and Label Studio's notes.json have their names.
INSIDE = ("names", "mask", "categories")


def read_names(path: Path) -> tuple[dict[int, str], bool]:
    """Names of values, and whether those are colors.

    Args:
        path: JSON or YAML of names by value; a list of names, which counts from 0; a list of entries that have value
            and label, or id and name; or text with a name in each line.

    Raises:
        InputError: none of these.
    """
    with explain_unreadable(path, "file of names", NAMES_OPTION):
        data = _load(path)
    data = next((data[key] for key in INSIDE if isinstance(data.get(key), (list, dict))), data) if _maps(data) else data
    if isinstance(data, list) and data and all(map(_maps, data)):
        data = {one.get("value", one.get("id")): one.get("label", one.get("name")) for one in data}
    elif isinstance(data, list):
        data = dict(enumerate(data))
    if not _maps(data) or not data:
        raise InputError(path, "holds no names.", NAMES_OPTION, code="E-MASKS-NAMES")
    if strange := [key for key in data if not re.fullmatch(r"\d{1,10}|#[0-9a-fA-F]{6}", str(key))]:
        raise InputError(path, f"names {strange[0]!r}, which is no value.", NAMES_OPTION, code="E-MASKS-NAMES")
    if not all(isinstance(name, str) and name.strip() for name in data.values()):
        raise InputError(path, "has values that are no names.", NAMES_OPTION, code="E-MASKS-NAMES")
    values = {str(key): name.strip(" .") or name for key, name in data.items()}
    names = {int(key[1:], 16) if key.startswith("#") else int(key): name for key, name in values.items()}
    return names, any(key.startswith("#") for key in values)


def _maps(data: Any) -> bool:
    return isinstance(data, dict)


def _load(path: Path) -> Any:
    text = decode_file(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return parse_yaml(path, text)
    if path.suffix.lower() in (".txt", ".names"):
        return [line for line in text.splitlines() if line.strip()]
    return json.loads(text)


def choose_named(
    path: Path, found: Mapping[int, str], labels: Path | None, names: Mapping[int, str], kind: str, fix: str
) -> list[int]:
    """Which of the numbers that masks have are named. The others are printed.

    Args:
        path: of the masks.
        found: the numbers, as they are told.
        labels: the file of names, if there is one.
        names: what it holds.
        kind: what the numbers are, in the plural.
        fix: how to give names.

    Raises:
        InputError: none is named.
    """
    if labels is None:
        raise InputError(path, f"has {len(found)} {kind} without names.", fix, code="E-MASKS-NAMES")
    known = [number for number in found if number in names]
    nameless = [told for number, told in found.items() if number not in names]
    if not known:
        what = f"names none of the {kind} of {path}: {', '.join(nameless[:5]) or 'nothing'}."
        raise InputError(labels, what, fix, code="E-MASKS-NAMES")
    if nameless:
        more = f" and {len(nameless) - LISTED} more" if len(nameless) > LISTED else ""
        print(f"{path}: without a name, left out: {', '.join(nameless[:LISTED])}{more}")
    return known
