"""Read one RGB-D view: picture and depth upright, its unit, the camera and its lens; each step from the files alone."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plugins.inputs.rgbd.cameras import read_upright_intrinsics
from plugins.inputs.rgbd.depth_files import convert_to_metres, read_raw
from plugins.inputs.rgbd.depth_scale import find_stated_units
from plugins.inputs.rgbd.frame import Frame
from plugins.inputs.rgbd.lens import find_distortion
from plugins.inputs.rgbd.upright import find_turn, turn_depth
from stages.contracts.images import check_shown, read_rgb

Intrinsics = Callable[[int, int, str], NDArray[np.float64]]  # K of a picture of this width, height and file name


@dataclass(frozen=True)
class View:
    """The files of one view.

    colour, depth: its pictures. intrinsics: of the camera. camera_file: where they are from, which may state a lens.
    unit_file: which may state the unit of the depth. usual: the number that stands for one metre where nobody states
    it. name, source: for the log: which frame it is, whose intrinsics.
    """

    colour: Path
    depth: Path
    intrinsics: Intrinsics
    camera_file: Path | None = None
    unit_file: Path | None = None
    usual: float | None = None
    name: str = ""
    source: str = ""


def read_view(view: View, unit: str) -> Frame:
    """Picture, depth and camera of a view, all upright; `unit` of the depth as of `convert_to_metres`.

    Raises:
        InputError: one of its files cannot be used, or it is unknown how they lie on each other.
    """
    rgb = read_rgb(view.colour)
    check_shown(view.colour, rgb)
    raw = read_raw(view.depth)
    turn = find_turn(view.colour, rgb)
    raw = turn_depth(turn, raw, view.depth)
    depth, line = convert_to_metres(view.depth, raw, unit, find_stated_units(view.depth, view.unit_file), view.usual)
    name = view.colour.name
    found, was_turned = read_upright_intrinsics(turn, lambda width, height: view.intrinsics(width, height, name))
    file = view.camera_file
    lens = None if file is None else find_distortion(file, found, turn.width, turn.height, name)
    if was_turned and lens is not None and (lens.any() or len(lens) == 4):
        raise turn.refusal("its lens")
    notes = [note for note in (view.name, line, view.source) if note]
    return Frame(rgb, depth, found, None, notes, lens, turn)
