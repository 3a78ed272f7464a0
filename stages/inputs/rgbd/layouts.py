"""Frames of RGB-D recordings as they lie on disk: which of a folder's files belong together.

Two layouts: TUM's lists of time stamps, and folders of colour and depth in the same order with a file of intrinsics
(Open3D, RealSense, Record3D's export as EXR and JPG). docs/your-data.md says how to bring others into the second one.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from stages.contracts import InputError
from stages.contracts.arrays import readable
from stages.contracts.images import check_shown, read_rgb
from stages.inputs.rgbd.cameras import Matrix, matrix, read_intrinsics, resized
from stages.inputs.rgbd.depth_files import FILES, in_metres, read_raw
from stages.inputs.rgbd.depth_scale import stated_beside
from stages.inputs.rgbd.frame import Frame
from stages.inputs.rgbd.lens import find_distortion
from stages.inputs.rgbd.upright import turn_of, upright_camera, upright_depth

PICTURES = (".png", ".jpg", ".jpeg", ".ppm")
COLOUR = ("color", "rgb", "image", "colour")  # what folders of pictures are called
ABOUT = ("camera.json", "config.json", "metadata.json", "metadata")  # files of intrinsics without that in their name
TUM_UNIT = 5000.0  # of one metre
TUM_APART = 0.02  # seconds between colour and depth of a frame, as in its associate.py
TUM_CAMERA = (525.0, 525.0, 319.5, 239.5)  # fx, fy, cx, cy, as its tools have them for all three cameras ...
TUM_SIZE = (640, 480)  # ... whose pictures are so wide and high

Intrinsics = Callable[[int, int, str], Matrix]  # of a picture of this width, height and file name


def read_views(colour: Path, file: Path, unit: str, about: Path | None = None, usual: float | None = None) -> Frame:
    """A picture and its depth, both upright, without intrinsics yet (the identity); a line says what the depth is.

    Args:
        colour: the picture's file.
        file: the depth's.
        unit: of the depth, as of `in_metres`.
        about: file of intrinsics, which may say the unit; else files beside the depth may.
        usual: the unit if nobody says it, see `in_metres`.

    Raises:
        InputError: one of them cannot be used, or nothing tells how they lie on each other.
    """
    rgb = read_rgb(colour)
    check_shown(colour, rgb)
    turn = turn_of(colour, rgb)
    raw = upright_depth(turn, read_raw(file), file)
    depth, line = in_metres(file, raw, unit, stated_beside(file, about), usual)
    return Frame(rgb, depth, np.eye(3), None, [line], None, turn)


def with_camera(frame: Frame, intrinsics: Intrinsics, about: Path | None) -> Frame:
    """The frame with intrinsics of its upright picture, and the lens of the file `about`.

    Raises:
        InputError: they are not of this picture, or of the turned picture of a lens that bends it.
    """
    turn = frame.turn
    assert turn is not None
    name = turn.path.name
    found, was_turned = upright_camera(turn, lambda width, height: intrinsics(width, height, name))
    lens = None if about is None else find_distortion(about, found, turn.width, turn.height, name)
    if was_turned and lens is not None and (lens.any() or len(lens) == 4):
        raise turn.refusal("its lens")
    return replace(frame, intrinsics=found, distortion=lens)


def read_frame(path: Path, number: int, unit: str, intrinsics: Intrinsics | None, about: Path | None = None) -> Frame:
    """Frame `number`, from 0, of a recording.

    Args:
        path: folder of the recording.
        number: of the frame, in the order of the recording.
        unit: of its depth, as of `in_metres`; auto: what its files say, TUM's own, or found by its median.
        intrinsics: what to use in the place of the recording's own.
        about: the file that they are from, if they are from one.

    Raises:
        InputError: no known layout, no such frame, or a broken one.
    """
    if (path / "rgb.txt").is_file() and (path / "depth.txt").is_file():
        return _of_lists(path, number, unit, intrinsics, about)
    colours = next((path / name for name in COLOUR if (path / name).is_dir()), None)
    if colours is not None and (path / "depth").is_dir():
        return _of_folders(path, colours, path / "depth", number, unit, intrinsics, about)
    what = "is no recording that is known (TUM, Open3D, RealSense, Record3D)."
    fix = "folders color and depth with intrinsics.json, or --rgb and --depth"
    raise InputError(path, what if path.exists() else "no such folder.", fix, code="E-RECORDING-LAYOUT")


def _one(frames: list[tuple[Path, Path]], number: int, where: Path) -> tuple[Path, Path]:
    if not 0 <= number < len(frames):
        what = f"{where} has {len(frames)} frames, counted from 0: there is no {number}."
        raise InputError("--number", what, "a smaller one", code="E-RECORDING-FRAME")
    return frames[number]


def _of_lists(path: Path, number: int, unit: str, intrinsics: Intrinsics | None, about: Path | None) -> Frame:
    """A frame of TUM: every picture with the depth image of the nearest time."""
    with readable(path / "rgb.txt", "list of a TUM recording"):
        colours, depths = _stamps(path / "rgb.txt"), _stamps(path / "depth.txt")
        times = np.array([stamp for stamp, _ in depths])
        nearest = [int(np.abs(times - stamp).argmin()) for stamp, _ in colours]
        both = zip(colours, nearest, strict=True)
        pairs = [(file, depths[k][1]) for (stamp, file), k in both if abs(times[k] - stamp) <= TUM_APART]
    colour, file = _one(pairs, number, path)
    frame = read_views(colour, file, unit, about, TUM_UNIT)
    notes = [f"TUM, {colour.name}", *frame.notes, *([] if intrinsics else ["intrinsics of TUM's tools"])]
    return with_camera(replace(frame, notes=notes), intrinsics or _of_tum, about)


def _of_tum(width: int, height: int, _: str) -> Matrix:
    return resized(matrix(*TUM_CAMERA), width / TUM_SIZE[0], height / TUM_SIZE[1])


def _stamps(path: Path) -> list[tuple[float, Path]]:
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    return [(float(stamp), path.parent / name) for stamp, name, *_ in lines]


def _of_folders(
    path: Path,
    colours: Path,
    depths: Path,
    number: int,
    unit: str,
    intrinsics: Intrinsics | None,
    about: Path | None,
) -> Frame:
    """A frame of folders whose files have the same order."""
    pictures, images = _files(colours, PICTURES), _files(depths, FILES)
    if len(pictures) != len(images):
        what = f"has {len(pictures)} pictures, but {len(images)} depth images."
        raise InputError(path, what, "one depth image for each picture", code="E-RECORDING-LAYOUT")
    colour, file = _one(list(zip(pictures, images, strict=True)), number, path)
    own = [one for one in sorted(path.iterdir()) if one.is_file() and "intrinsic" in one.name.lower()]
    own += [path / name for name in ABOUT if (path / name).is_file()]
    if intrinsics is None and not own:
        raise InputError(
            path, "has no file of intrinsics.", "give --intrinsics, --camera or --fov", code="E-CAMERA-MISSING"
        )
    frame = read_views(colour, file, unit, about or next(iter(own), None))
    notes = [f"{colour.name} and {file.name}", *frame.notes]
    if intrinsics is not None:
        return with_camera(replace(frame, notes=notes), intrinsics, about)
    frame = replace(frame, notes=[*notes, f"intrinsics of {own[0].name}"])
    return with_camera(frame, partial(read_intrinsics, own[0]), own[0])


def _files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    found = [file for file in folder.iterdir() if file.suffix.lower() in suffixes]
    return sorted(found, key=lambda file: (len(file.stem), file.stem))  # 10 after 9
