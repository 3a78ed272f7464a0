"""Read depth from OpenEXR files, by the names of their layers."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError

DEPTH_LAYERS = ("depth", "z", "distance", "dist", "zdepth", "depthmap")  # what layers and channels of depth are called
DEPTH_CHANNELS = ("z", "depth", "v", "y", "r", "d", "x", "")  # channels of a layer of depth, the best first


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
            before = f"{part.name()}." if len(file.parts) > 1 and part.name() else ""
            channels |= {before + name: np.array(one.pixels) for name, one in file.channels(number).items()}
    name = depth_channel(path, channels)
    if len(channels) > 1:
        others = ", ".join(one for one in channels if one != name)
        print(f"{path}: depth is its channel {name}, not {others}")
    return channels[name]


def depth_channel(path: Path, channels: dict[str, NDArray[Any]]) -> str:
    """The name of the depth channel: by its own name or that of its layer; else the only one, or red of equal colours.

    Raises:
        InputError: there is none, or several.
    """
    ranked = {name: rank for name in channels if (rank := _rank(name)) is not None and not _is_part(name, channels)}
    best = [name for name, rank in ranked.items() if rank == min(ranked.values())]
    plain = [name for name in channels if not _is_part(name, channels)]
    if not best and (len(plain) == 1 or {name.lower() for name in plain} == set("rgb")):
        best = sorted(plain)[-1:]
    if len(best) != 1:
        what = f"has the channels {', '.join(best or channels)}: which of them is depth?"
        raise InputError(path, what, "save depth alone, or call its channel Z", code="E-DEPTH-FORMAT")
    return best[0]


def _is_part(name: str, channels: dict[str, NDArray[Any]]) -> bool:
    """Whether a channel is of a vector (X, Y, Z) or of a colour (R, G, B that differ)."""
    layer, channel = name[:-1], name[-1:].upper()
    for parts in ("XYZ", "RGB"):
        own = [one for one in channels if one[:-1] == layer and one[-1:].upper() in parts]
        if channel in parts and len(own) == 3:
            same = all(np.array_equal(channels[own[0]], channels[one], equal_nan=True) for one in own)
            return parts == "XYZ" or not same
    return False


def _rank(name: str) -> int | None:
    """How surely a channel is depth by its name, 0 the most; None: not at all."""
    *layers, channel = re.split(r"[.:/]", name.lower())
    if channel in ("z", "depth"):
        return 0
    words = [word for layer in layers for word in re.findall(r"[a-z]+", layer)]
    if channel in DEPTH_CHANNELS and any(word in DEPTH_LAYERS or "depth" in word for word in words):
        return 1 + DEPTH_CHANNELS.index(channel)
    return 1 + len(DEPTH_CHANNELS) if channel in DEPTH_LAYERS else None
