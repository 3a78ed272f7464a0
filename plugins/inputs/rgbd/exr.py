"""Read depth from OpenEXR files, by the names of their layers."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError


def read_exr(path: Path) -> NDArray[Any]:
    """The channel (h, w) of depth, which is printed if there are others.

    Raises:
        InputError: OpenEXR is not installed, or no channel, or more than one, is called as depth is.
    """
    try:
        import OpenEXR
    except ImportError:
        raise InputError(
            path, "is an EXR file, which nothing installed here reads.", "pip install OpenEXR", code="E-LIBRARY-MISSING"
        ) from None
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels: dict[str, NDArray[Any]] = {}
        for number, part in enumerate(file.parts):
            _check_windows(path, part.header)
            before = f"{part.name()}." if len(file.parts) > 1 and part.name() else ""
            channels |= {before + name: np.array(one.pixels) for name, one in file.channels(number).items()}
    name = depth_channel(path, channels)
    if len(channels) > 1:
        others = ", ".join(one for one in channels if one != name)
        print(f"{path}: depth is its channel {name}, not {others}")
    return channels[name]


def _check_windows(path: Path, header: dict[str, Any]) -> None:
    """Refuse a part of a picture, or one with a border: it would be stretched over the picture.

    Raises:
        InputError: the window of its pixels is not the one that is shown.
    """
    data, shown = (np.asarray(header[name]).tolist() for name in ("dataWindow", "displayWindow"))
    if data != shown:
        what = f"holds the pixels {data} of {shown} (dataWindow, displayWindow)."
        raise InputError(path, what, "save it without crop and overscan", code="E-DEPTH-SIZE")


def depth_channel(path: Path, channels: dict[str, NDArray[Any]]) -> str:
    """The name of the depth channel: one called Z or depth, or of a layer called so; else any, if all are the same.

    Raises:
        InputError: it may be one of several.
    """
    named = [name for name in channels if "depth" in re.split(r"\W+", name.lower()) or _is_z(name, channels)]
    first, *others = named or list(channels)
    if not all(np.array_equal(channels[first], channels[other], equal_nan=True) for other in others):
        what = f"has the channels {', '.join(named or channels)}: which of them is depth?"
        raise InputError(path, what, "save depth alone, or call its channel Z", code="E-DEPTH-FORMAT")
    return first


def _is_z(name: str, channels: dict[str, NDArray[Any]]) -> bool:
    """Whether a channel is called Z, and is none of a vector."""
    *layer, channel = name.split(".")
    return channel.lower() == "z" and ".".join([*layer, "X"]) not in channels
