"""Command `measure`: a photograph -> a picture with depth by a network (paper A.2), for `see`."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import MeasureOptions
from roomkin.stages.config.recordings import name_picture
from roomkin.stages.contracts import read_options
from roomkin.stages.contracts.images import NEAREST
from roomkin.stages.geometry.frames import back_project, make_intrinsics
from roomkin.stages.geometry.levels import find_ground
from roomkin.stages.geometry.room_planes import STRAY, Plane, make_floor_frame
from roomkin.stages.perception.camera.perspective import fit_view, propose, usual_focal
from roomkin.stages.perception.read.cameras import Matrix
from roomkin.stages.perception.read.frame import TILT, Frame
from roomkin.stages.perception.read.photo import read_known
from roomkin.stages.perception.write import write_frame
from roomkin.stages.plugins import load

SOURCE = "depth_anything"


def run(*, image: Path, out: Path, options: str = "{}", device: str = "cpu") -> None:
    """Measure a picture's depth by a network, and find its camera.

    Args:
        image: the picture.
        out: folder for rgb.png, depth.npz and camera.json, which `see` reads.
        options: JSON of the config section `perception`.
        device: of the network: cpu or cuda.

    Raises:
        InputError: the picture cannot be used; the weights are missing, broken, or of another kind.
    """
    settings = read_options(MeasureOptions, options)
    photo, focal, source = read_known(image, settings)
    if photo.shrunk > 1:
        print(f"{image}: made smaller, to {photo.rgb.shape[1]}x{photo.rgb.shape[0]} pixels")
    depth = load("depth_sources", SOURCE)(photo.rgb, settings, device)
    intrinsics, note = find_camera(photo.rgb, focal, source)
    pose = None
    if find_ground(back_project(depth.astype(float), intrinsics), depth > 0, TILT) is None:
        pose = level_by_lines(photo.rgb, depth, intrinsics)
        note += f"; no floor is seen: level by lines, {pose[2, 3]:.2f} m above the lowest point"
    print(note)
    name = name_picture(image)
    write_frame(out, Frame(photo.rgb, depth, intrinsics, doubt=note, pose=pose, picture=name, digest=photo.digest))


def find_camera(rgb: NDArray[np.uint8], focal: float | None, source: str) -> tuple[Matrix, str]:
    """K of a picture (H, W, 3), and a line with the source of its focal length: known, lines, a usual camera."""
    height, width = rgb.shape[:2]
    if focal is None:
        proposed = propose(rgb, usual_focal(width, height, None))
        usual = "a usual camera, as nothing tells it: perception.field_of_view sets it"
        focal, source = proposed.likely_focal, "lines in the picture" if proposed.guides else usual
    degrees = np.rad2deg(2 * np.arctan(width / 2 / focal))
    line = f"focal length {focal:.0f} pixels, {degrees:.0f} degrees across: by {source}"
    return make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2), line


def level_by_lines(rgb: NDArray[np.uint8], depth: NDArray[np.float32], intrinsics: Matrix) -> NDArray[np.float64]:
    """`floor_from_camera` (4, 4) of a picture (H, W, 3), its floor below all that is seen."""
    points, seen = back_project(depth.astype(float), intrinsics), depth > 0
    height, width = depth.shape
    up = fit_view(propose(rgb, usual_focal(width, height, float(intrinsics[0, 0]))), width, height).rotation[2]
    lowest = float(np.quantile(points[seen] @ up, STRAY))
    return make_floor_frame(Plane(up, min(lowest, -NEAREST), np.zeros(0, dtype=bool)))
