"""Verb `from-rgbd`: a frame of an RGB-D camera or data set -> an input folder."""

from dataclasses import replace
from pathlib import Path
from typing import Literal

import cv2
import numpy as np

from stages.contracts import InputError, atomic
from stages.geometry.ray_depth import along_axis, flatter_along
from stages.inputs.numbered import numbered
from stages.inputs.rgbd.cameras import KNOWS, Matrix, checked, of_camera, of_field_of_view, read_intrinsics
from stages.inputs.rgbd.cameras import matrix as intrinsics_of
from stages.inputs.rgbd.clusters import clustered
from stages.inputs.rgbd.edges import without_edges
from stages.inputs.rgbd.frame import Frame, is_nothing
from stages.inputs.rgbd.layouts import read_frame, read_views, with_camera
from stages.inputs.rgbd.lens import straight_frame
from stages.inputs.rgbd.mask_files import read_labelled
from stages.inputs.rgbd.mask_shapes import listed
from stages.inputs.rgbd.upright import upright_masks
from stages.inputs.rgbd.write import fitted, write_frame


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
    clusters: bool = False,
) -> None:
    """Write an input folder from colour and depth of one view.

    Args:
        out: the input folder to write (docs/scenes.md).
        rgb: the colour picture.
        depth: depth aligned to it, at any size: PNG, TIFF, PGM, EXR, NPZ, NPY.
        recording: in the place of both, the folder of a recording: TUM, Open3D, RealSense, Record3D.
        number: which frame of the recording, from 0.
        unit: of the depth: auto (by files beside it, else its median), m, mm, or the number that stands for one metre.
        intrinsics: file with the colour camera's intrinsics (JSON, YAML, text); distortion in it is taken out.
        camera: its name, in the place of a file, e.g. realsense_d435.
        fov: its field of view over the picture's width in degrees, in the place of both.
        matrix: fx, fy, cx, cy in pixels, in the place of all three.
        depth_is: z: the distance along the optical axis; ray: along the ray of each pixel, as of many simulators.
        masks: COCO or labelme JSON, or a PNG of indices or colours.
        labels: names of the PNG's values, as JSON.
        clusters: make masks of what stands on a table or floor, by depth alone, to be named by you.
    """
    known = sum((intrinsics is not None, bool(camera), fov > 0, bool(matrix)))
    if known > 1:
        raise InputError(
            "--intrinsics, --camera, --fov, --matrix",
            "say the same thing.",
            "give one of them",
            code="E-OPTION-CONFLICT",
        )
    if matrix and len(matrix) != 4:
        raise InputError(
            "--matrix", f"has {len(matrix)} numbers.", "fx fy cx cy, in pixels", code="E-CAMERA-INTRINSICS"
        )

    def told(width: int, height: int, picture: str) -> Matrix:
        if intrinsics is not None:
            return read_intrinsics(intrinsics, width, height, picture)
        if matrix:
            return checked("--matrix", intrinsics_of(*matrix), width, height)
        return of_camera(camera, width, height) if camera else of_field_of_view(fov, width, height)

    if recording is not None:
        if rgb is not None or depth is not None:
            raise InputError(
                "--recording", "has its own pictures.", "leave out --rgb and --depth", code="E-OPTION-CONFLICT"
            )
        frame = read_frame(recording, number, unit, told if known else None, intrinsics)
    elif rgb is None or depth is None:
        raise InputError("--rgb, --depth", "both are needed.", "or give --recording", code="E-OPTION-MISSING")
    elif not known:
        raise InputError(
            rgb,
            "nothing says what camera took it.",
            f"--intrinsics: {KNOWS}; or --camera, or --fov",
            code="E-CAMERA-MISSING",
        )
    else:
        frame = with_camera(read_views(rgb, depth, unit, intrinsics), told, intrinsics)
    if masks is not None:
        frame = _masked(frame, masks, labels)
    frame = _straight(frame, masks)
    doubt = ""
    if depth_is == "ray":
        frame = replace(frame, depth=along_axis(frame.depth, frame.intrinsics))
    if flatter := flatter_along(frame.depth, frame.intrinsics):
        doubt = f"depth in doubt: floor and walls would be flat with --depth-is {'ray' if flatter == 'ray' else 'z'}"
        print(f"{depth or recording}: {doubt}")
    if frame.masks is not None:
        frame = replace(frame, depth=without_edges(frame.depth, frame.masks.values))
    if clusters and masks is None:
        frame = replace(frame, masks=clustered(frame.depth, frame.intrinsics))
    height, width = frame.rgb.shape[:2]
    written = write_frame(out, frame, doubt)
    (fx, _, cx), (_, fy, cy), _ = frame.intrinsics
    print("; ".join([*frame.notes, f"fx {fx:.1f} fy {fy:.1f} cx {cx:.1f} cy {cy:.1f} of {width}x{height} pixels"]))
    if written is None:
        print(f"{out}: no masks. Draw boxes: python -m stages.inputs annotate {out / 'rgb.png'} --out {out} "
              f"--depth {out / 'depth.npz'} --camera {out / 'camera.json'}; or give --masks or --clusters")  # fmt: skip
        return
    opens = [item.label for item in written.objects if item.articulated]
    floor = "a floor" if written.floor else "no floor named: what most of them stand on is the ground"
    print(f"{out}: {len(written.objects)} objects, {len(written.walls)} walls, {floor}")
    if clusters and masks is None and frame.masks is not None:
        shown = [frame.masks.values == value for value in frame.masks.labels]
        with atomic(out / "numbers.png") as path:
            cv2.imwrite(str(path), numbered(frame.rgb, shown)[..., ::-1])
        print(f"{out / 'annotations.json'}: say in it what each object is: numbers.png shows which mask it has; "
              f"or in the browser: python -m stages.inputs annotate {out}")  # fmt: skip
    if opens:
        print(f"{out / 'annotations.json'}: say in it how many doors and drawers there are: {', '.join(opens)}")


def _masked(frame: Frame, masks: Path, labels: Path | None) -> Frame:
    """The frame with the masks of a file."""
    assert frame.turn is not None
    turn, name = frame.turn, frame.turn.path.name
    found = upright_masks(turn, lambda width, height: read_labelled(masks, labels, width, height, name), masks)
    if nothing := [(label, "is nothing to place") for label in found.labels.values() if is_nothing(label)]:
        print(f"{masks}: left out: {listed(nothing)}")
    return replace(frame, masks=found)


def _straight(frame: Frame, masks: Path | None) -> Frame:
    """The frame at one size as a pinhole camera would see it. Prints which masks have no pixels in that."""
    straight = straight_frame(fitted(frame))
    if frame.masks is not None and straight.masks is not None:
        kept = set(np.unique(straight.masks.values).tolist())
        lost = [(name, "has no pixels") for value, name in frame.masks.labels.items() if value not in kept]
        if lost:
            count = len(frame.masks.labels)
            print(f"{masks}: made straight and fitted, {count - len(lost)} of {count} are left: {listed(lost)}")
    return straight
