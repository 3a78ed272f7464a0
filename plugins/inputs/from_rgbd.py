"""Verb `from-rgbd`: a frame of an RGB-D camera or data set -> an input folder."""

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from plugins.inputs.rgbd.cameras import KNOWS, choose_intrinsics
from plugins.inputs.rgbd.edges import remove_edges
from plugins.inputs.rgbd.frame import Frame, fit_frame
from plugins.inputs.rgbd.layouts import find_view
from plugins.inputs.rgbd.lens import straighten_frame
from plugins.inputs.rgbd.mask_files import read_upright_masks
from plugins.inputs.rgbd.mask_shapes import list_remarks
from plugins.inputs.rgbd.views import View, read_view
from plugins.inputs.rgbd.write import write_frame
from stages.contracts import Annotations, InputError
from stages.geometry.ray_depth import along_axis, find_flatter


def run(
    *,
    out: Path,
    rgb: Path | None = None,
    depth: Path | None = None,
    recording: Path | None = None,
    number: int = 0,
    unit: str = "auto",
    intrinsics: Path | None = None,
    camera: str = "",
    fov: float = 0.0,
    matrix: tuple[float, ...] = (),
    depth_is: Literal["z", "ray"] = "z",
    masks: Path | None = None,
    labels: Path | None = None,
) -> None:
    """Write an input folder from colour and depth of one view.

    Args:
        out: the input folder to write (docs/scenes.md).
        rgb: the colour picture.
        depth: depth aligned to it, at any size: PNG, TIFF, PGM, EXR, NPZ, NPY.
        recording: instead of both, the folder of a recording: TUM, Open3D, RealSense, Record3D.
        number: which frame of the recording, from 0.
        unit: of the depth: auto (by files beside it, else its median), m, mm, or the number that stands for one metre.
        intrinsics: file with the colour camera's intrinsics (JSON, YAML, text); distortion in it is taken out.
        camera: its name, instead of a file, e.g. realsense_d435.
        fov: its field of view over the picture's width in degrees, instead of both.
        matrix: fx, fy, cx, cy in pixels, instead of all three.
        depth_is: z: the distance along the optical axis; ray: along the ray of each pixel, as of many simulators.
        masks: COCO or labelme JSON, or a PNG of indices or colours.
        labels: names of the PNG's values, as JSON.
    """
    stated = choose_intrinsics(intrinsics, camera, fov, matrix)
    if recording is not None:
        if rgb is not None or depth is not None:
            raise InputError(
                "--recording", "has its own pictures.", "leave out --rgb and --depth", code="E-OPTION-CONFLICT"
            )
        view = find_view(recording, number, stated, intrinsics)
    elif rgb is None or depth is None:
        raise InputError("--rgb, --depth", "both are needed.", "or give --recording", code="E-OPTION-MISSING")
    elif stated is None:
        raise InputError(
            rgb,
            "nothing says what camera took it.",
            f"--intrinsics: {KNOWS}; or --camera, or --fov",
            code="E-CAMERA-MISSING",
        )
    else:
        view = View(rgb, depth, stated, intrinsics, intrinsics)
    frame = read_view(view, unit)
    if masks is not None:
        assert frame.turn is not None
        frame = replace(frame, masks=read_upright_masks(masks, labels, frame.turn))
    before = frame.masks
    frame = straighten_frame(fit_frame(frame))
    if masks is not None and before is not None and frame.masks is not None:
        kept = set(np.unique(frame.masks.values).tolist())
        if lost := [(name, "has no pixels") for value, name in before.labels.items() if value not in kept]:
            left = f"{len(before.labels) - len(lost)} of {len(before.labels)}"
            print(f"{masks}: made straight and fitted, {left} are left: {list_remarks(lost)}")
    if depth_is == "ray":
        frame = replace(frame, depth=along_axis(frame.depth, frame.intrinsics))
    doubt = ""
    if flatter := find_flatter(frame.depth, frame.intrinsics):
        doubt = f"depth in doubt: floor and walls would be flat with --depth-is {'ray' if flatter == 'ray' else 'z'}"
        print(f"{depth or recording}: {doubt}")
    if frame.masks is not None:
        frame = replace(frame, depth=remove_edges(frame.depth, frame.masks.values))
    written = write_frame(out, frame, doubt)
    print_summary(out, frame, written)


def print_summary(out: Path, frame: Frame, written: Annotations | None) -> None:
    """Print what was written, and what is to be done with it."""
    height, width = frame.rgb.shape[:2]
    (fx, _, cx), (_, fy, cy), _ = frame.intrinsics
    print("; ".join([*frame.notes, f"fx {fx:.1f} fy {fy:.1f} cx {cx:.1f} cy {cy:.1f} of {width}x{height} pixels"]))
    if written is None:
        print(f"{out}: no masks. Find things: python -m plugins.eyes see --picture {out} --out FOLDER")
        print(f"Or draw boxes: python -m plugins.studio annotate {out / 'rgb.png'} --out {out} --depth "
              f"{out / 'depth.npz'} --camera {out / 'camera.json'}; or give --masks")  # fmt: skip
        return
    floor = "a floor" if written.floor else "no floor named: what most of them stand on is the ground"
    print(f"{out}: {len(written.objects)} objects, {len(written.walls)} walls, {floor}")
    if opens := [item.label for item in written.objects if item.articulated]:
        print(f"Say how many doors and drawers there are: {', '.join(dict.fromkeys(opens))}")
