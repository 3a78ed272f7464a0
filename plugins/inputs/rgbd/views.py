"""Read one RGB-D view: picture, depth, camera and masks; upright, straight and at one size; from the files alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from plugins.inputs.rgbd.belonging import doubt_depth
from plugins.inputs.rgbd.camera_files import KNOWS
from plugins.inputs.rgbd.cameras import check_intrinsics, intrinsics_of_camera, intrinsics_of_view
from plugins.inputs.rgbd.depth_files import convert_to_metres, read_raw
from plugins.inputs.rgbd.depth_scale import find_stated_units
from plugins.inputs.rgbd.frame import Frame, check_upright, fit_frame
from plugins.inputs.rgbd.lens import Lens, read_lens, straighten_frame
from plugins.inputs.rgbd.mask_files import read_labelled
from plugins.inputs.rgbd.mask_shapes import list_remarks
from plugins.inputs.rgbd.pieces import doubt_surfaces, split_values
from plugins.inputs.rgbd.surfaces import surface_of
from stages.contracts import InputError
from stages.contracts.images import check_shown, read_rgb
from stages.geometry.cameras import make_intrinsics
from stages.geometry.ray_depth import along_axis, find_flatter

CameraReader = Callable[[int, int, str], Lens]  # the camera of a picture of this width, height and file name


@dataclass(frozen=True)
class View:
    """The files of one view.

    color, depth: its pictures. camera: what reads it. unit_file: which may state the unit of the depth. usual: the
    number that stands for one metre where nobody states it. notes: for the log, which frame it is, whose intrinsics.
    """

    color: Path
    depth: Path
    camera: CameraReader
    unit_file: Path | None = None
    usual: float | None = None
    notes: tuple[str, ...] = ()


def choose_camera(given: Sequence[str]) -> tuple[CameraReader | None, Path | None]:
    """What reads the camera, and its file, by the words of an option: a file; a name; degrees; or fx, fy, cx, cy.

    Raises:
        InputError: so many words are none of these.
    """
    if not given:
        return None, None
    try:
        numbers = [float(word) for word in given]
    except ValueError:
        numbers = []
    if len(numbers) == 4:
        matrix = make_intrinsics(*numbers)
        return lambda width, height, _: Lens(check_intrinsics("--camera", matrix, width, height)), None
    if len(given) > 1:
        what, fix = f"has {len(given)} words.", f"a file, a name, degrees, or fx fy cx cy in pixels: {KNOWS}"
        raise InputError("--camera", what, fix, code="E-CAMERA-INTRINSICS")
    if numbers:
        return lambda width, height, _: Lens(intrinsics_of_view(numbers[0], width, height)), None
    if (file := Path(given[0])).exists() or file.suffix:
        return partial(read_lens, file), file
    return lambda width, height, _: Lens(intrinsics_of_camera(given[0], width, height)), None


def read_frame(view: View, unit: str, depth_is: str, masks: Path | None, labels: Path | None) -> Frame:
    """Picture, depth, camera and masks of a view. What is lost of the masks is printed.

    Args:
        view: the files.
        unit: of the depth, as of `convert_to_metres`.
        depth_is: z or ray: what the numbers are distances along.
        masks: a file of masks.
        labels: names of their values.

    Raises:
        InputError: one of its files cannot be used, or they do not lie on each other.
    """
    rgb = read_rgb(view.color)
    check_shown(view.color, rgb)
    check_upright(view.color)
    raw = read_raw(view.depth)
    depth, line = convert_to_metres(view.depth, raw, unit, find_stated_units(view.depth, view.unit_file), view.usual)
    shown = (rgb.shape[1], rgb.shape[0], view.color.name)
    lens = view.camera(*shown)
    labelled = None if masks is None else read_labelled(masks, labels, *shown)
    notes = [*view.notes[:1], line, *view.notes[1:]]
    frame = straighten_frame(fit_frame(Frame(rgb, depth, lens.intrinsics, labelled, notes)), lens.distortion)
    if labelled is not None and frame.masks is not None:
        kept = set(np.unique(frame.masks.values).tolist())
        if lost := [(name, "has no pixels") for value, name in labelled.labels.items() if value not in kept]:
            left = f"{len(labelled.labels) - len(lost)} of {len(labelled.labels)}"
            print(f"{masks}: made straight and fitted, {left} are left: {list_remarks(lost)}")
    if depth_is == "ray":
        frame = replace(frame, depth=along_axis(frame.depth, frame.intrinsics))
    if flatter := find_flatter(frame.depth, frame.intrinsics):
        doubt = f"depth in doubt: floor and walls would be flat with --depth-is {'ray' if flatter == 'ray' else 'z'}"
        print(f"{view.depth}: {doubt}")
        frame = replace(frame, doubt=doubt)
    return frame if frame.masks is None else _compare_masks(view.depth, frame)


def _compare_masks(depth: Path, frame: Frame) -> Frame:
    """The frame with what its masks and its depth say of each other."""
    assert frame.masks is not None
    things = [value for value, label in frame.masks.labels.items() if not surface_of(label)]
    if doubt := doubt_depth(frame.depth, frame.masks.values, things):
        print(f"{depth}: {doubt}")
        frame = replace(frame, doubt="; ".join(filter(None, [frame.doubt, doubt])))
    return doubt_surfaces(split_values(frame))
