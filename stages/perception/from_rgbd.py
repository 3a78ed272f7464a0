"""Command `from-rgbd`: a frame of an RGB-D camera or data set -> an input folder."""

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Literal

from roomkin.stages.config.recordings import name_picture
from roomkin.stages.contracts import Annotations, InputError
from roomkin.stages.contracts.hand import hand_folder
from roomkin.stages.perception.read.camera_files import KNOWS
from roomkin.stages.perception.read.frame import Frame
from roomkin.stages.perception.read.views import ViewFiles, choose_camera, find_view, read_frame
from roomkin.stages.perception.write import write_frame


def run(
    *,
    out: Path,
    rgb: Path | None = None,
    depth: Path | None = None,
    recording: Path | None = None,
    number: int = 0,
    unit: str = "auto",
    camera: tuple[str, ...] = (),
    depth_is: Literal["z", "ray"] = "z",
    masks: Path | None = None,
    labels: Path | None = None,
) -> None:
    """Write an input folder from color and depth of one view.

    Args:
        out: the input folder to write (docs/scenes.md).
        rgb: the color picture.
        depth: depth aligned to it, at any size: PNG, TIFF, PGM, EXR, NPZ, NPY.
        recording: instead of both, the folder of a recording: TUM, Open3D, RealSense, Record3D, Stray Scanner.
        number: which frame of the recording, from 0.
        unit: of the depth: auto (by files beside it, else its median), m, mm, or the number that stands for one metre.
        camera: of the picture: a file of intrinsics (JSON, YAML, text), from which distortion is taken out, too; its
            name, e.g. realsense_d435; the field of view over the picture's width in degrees; or fx fy cx cy in pixels.
        depth_is: z: the distance along the optical axis; ray: along the ray of each pixel, as of many simulators.
        masks: COCO, labelme or segment-anything JSON, YOLO's text, a folder of outlines (0.png, 1.png, ...), a PNG of
            indices or colors, or an array of indices (NPY, NPZ).
        labels: what their numbers are called, if they do not say it: JSON, YOLO's data.yaml, or a name a line.
    """
    read_camera, camera_file = choose_camera(camera)
    if recording is not None:
        if rgb is not None or depth is not None:
            what = "has its own pictures."
            raise InputError("--recording", what, "leave out --rgb and --depth", code="E-OPTION-CONFLICT")
        view = find_view(recording, number, read_camera, camera_file)
    elif rgb is None or depth is None:
        raise InputError("--rgb, --depth", "both are needed.", "or give --recording", code="E-OPTION-MISSING")
    elif read_camera is None:
        fix = f"--camera: its name, degrees over the width, or {KNOWS}"
        raise InputError(rgb, "nothing says what camera took it.", fix, code="E-CAMERA-MISSING")
    else:
        view = ViewFiles(rgb, depth, read_camera, camera_file)
    frame = read_frame(view, unit, depth_is, masks, labels)
    frame = replace(frame, picture=name_picture(rgb) if rgb else "")
    print_summary(out, frame, write_frame(out, frame))


def print_summary(out: Path, frame: Frame, written: Annotations | None) -> None:
    """Print what was written, and what is to be done with it."""
    height, width = frame.rgb.shape[:2]
    (fx, _, cx), (_, fy, cy), _ = frame.intrinsics
    print("; ".join([*frame.notes, f"fx {fx:.1f} fy {fy:.1f} cx {cx:.1f} cy {cy:.1f} of {width}x{height} pixels"]))
    if written is None and hand_folder(out) != out:
        print(f"{out}: no masks: things are found next")
        return
    if written is None:
        quoted = shlex.quote(str(out))
        print(f"{out}: no masks. Find things: roomkin perception see --picture {quoted} --out FOLDER")
        print(f"Or click them: roomkin annotator annotate {quoted}; or give --masks")
        return
    floor = "a floor" if written.floor else "no floor named: what most of them stand on is the ground"
    print(f"{out}: {len(written.objects)} objects, {len(written.walls)} walls, {floor}")
    if opens := [item.label for item in written.objects if item.articulated]:
        print(f"Say how many doors and drawers there are: {', '.join(dict.fromkeys(opens))}")
