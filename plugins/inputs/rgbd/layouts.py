"""The files of one frame of an RGB-D recording: which of a folder's files belong together.

Two layouts: TUM's lists of time stamps, and folders of color and depth with the same numbers and a file of intrinsics
(Open3D, RealSense, Record3D's export as EXR and JPG). docs/your-data.md says how to bring others into the second one.
"""

import re
from functools import partial
from pathlib import Path

import numpy as np

from plugins.inputs.pictures import COLOR
from plugins.inputs.rgbd.depth_files import DEPTH_FILES
from plugins.inputs.rgbd.lens import Lens, read_lens
from plugins.inputs.rgbd.views import CameraReader, View
from stages.contracts import InputError
from stages.contracts.arrays import explain_unreadable
from stages.geometry.cameras import make_intrinsics, scale_intrinsics

PICTURES = (".png", ".jpg", ".jpeg", ".ppm")
CAMERA_FILES = ("camera.json", "config.json", "metadata.json", "metadata")  # besides those with `intrinsic` in the name


def find_view(path: Path, number: int, camera: CameraReader | None, camera_file: Path | None = None) -> View:
    """Frame `number`, from 0, of a recording.

    Args:
        path: folder of the recording.
        number: of the frame, in the order of the recording.
        camera: what to use in the place of the recording's own.
        camera_file: the file that it is from, if it is from one.

    Raises:
        InputError: no known layout, no such frame, or a broken one.
    """
    frames = list_frames(path)
    if not 0 <= number < len(frames):
        what = f"{path} has {len(frames)} frames, counted from 0: there is no {number}."
        raise InputError("--number", what, "a smaller one", code="E-RECORDING-FRAME")
    color, depth = frames[number]
    if _is_tum(path):
        source = [] if camera else ["intrinsics of TUM's tools"]
        return View(color, depth, camera or _make_tum_camera, camera_file, 5000.0, (f"TUM, {color.name}", *source))
    pictures, images = _list_folders(path) or ([], [])
    left = len(pictures) + len(images) - 2 * len(frames)
    notes = [f"{color.name} and {depth.name}" + (f" ({left} files have no partner of their number)" if left else "")]
    own = _list_camera_files(path)
    if camera is None:
        if not own:
            raise InputError(path, "has no file of intrinsics.", "give --camera", code="E-CAMERA-MISSING")
        if len({one.read_bytes() for one in own}) > 1:
            what = f"has several files of intrinsics: {', '.join(one.name for one in own)}."
            raise InputError(path, what, "give that of the color camera as --camera", code="E-CAMERA-SEVERAL")
        camera = partial(read_lens, own[0])
        notes.append(f"intrinsics of {own[0].name}")
    return View(color, depth, camera, camera_file or next(iter(own), None), None, tuple(notes))


def _list_camera_files(path: Path) -> list[Path]:
    """The recording's files of intrinsics: those that say color, else all that say intrinsics, else one called so."""
    own = [one for one in sorted(path.iterdir()) if one.is_file() and "intrinsic" in one.name.lower()]
    own = [one for one in own if set(re.findall("[a-z]+", one.stem.lower())) & set(COLOR)] or own
    return own or [path / name for name in CAMERA_FILES if (path / name).is_file()][:1]


def list_frames(path: Path) -> list[tuple[Path, Path]]:
    """Color and depth of every frame of a recording, in its order.

    Raises:
        InputError: no known layout, or a broken one.
    """
    if _is_tum(path):
        return _list_of_tum(path)
    if folders := _list_folders(path):
        return _pair_files(path, *folders)
    what = "is no recording that is known (TUM, Open3D, RealSense, Record3D)."
    fix = "folders color and depth with intrinsics.json, or --rgb and --depth"
    raise InputError(path, what if path.exists() else "no such folder.", fix, code="E-RECORDING-LAYOUT")


def _list_folders(path: Path) -> tuple[list[Path], list[Path]] | None:
    """The files of the folders of color and depth, if there are such.

    Raises:
        InputError: there are several of color.
    """
    colors = [path / name for name in COLOR if (path / name).is_dir()]
    if not colors or not (path / "depth").is_dir():
        return None
    if len(colors) > 1:
        what = f"has several folders of pictures: {', '.join(one.name for one in colors)}."
        raise InputError(path, what, "leave the one that depth is aligned to", code="E-RECORDING-LAYOUT")
    return _list_files(colors[0], PICTURES), _list_files(path / "depth", DEPTH_FILES)


def _is_tum(path: Path) -> bool:
    return (path / "rgb.txt").is_file() and (path / "depth.txt").is_file()


def _list_of_tum(path: Path) -> list[tuple[Path, Path]]:
    """Every picture of TUM with the depth image nearest in time, 20 ms apart at most (its associate.py)."""
    with explain_unreadable(path / "rgb.txt", "list of a TUM recording"):
        colors, depths = _read_stamps(path / "rgb.txt"), _read_stamps(path / "depth.txt")
        times = np.array([stamp for stamp, _ in depths])
        nearest = [int(np.abs(times - stamp).argmin()) for stamp, _ in colors]
        both = zip(colors, nearest, strict=True)
        return [(file, depths[k][1]) for (stamp, file), k in both if abs(times[k] - stamp) <= 0.02]


def _make_tum_camera(width: int, height: int, _: str) -> Lens:
    """All three cameras, as TUM's tools have them for pictures of 640 x 480."""
    return Lens(scale_intrinsics(make_intrinsics(525.0, 525.0, 319.5, 239.5), width / 640, height / 480))


def _read_stamps(path: Path) -> list[tuple[float, Path]]:
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    return [(float(stamp), path.parent / name) for stamp, name, *_ in lines]


def _pair_files(path: Path, pictures: list[Path], images: list[Path]) -> list[tuple[Path, Path]]:
    """Pictures with the depth images of the same numbers: all of a name's, or the first or last, whichever pairs most.

    Raises:
        InputError: the numbers pair less than half of them.
    """
    pairs: list[tuple[Path, Path]] = []
    for part in (slice(None), slice(0, 1), slice(-1, None)):
        colors, depths = (_number_files(files, part) for files in (pictures, images))
        pairs = max(pairs, [(colors[number], depths[number]) for number in colors if number in depths], key=len)
    if not pairs or 2 * len(pairs) < min(len(pictures), len(images)):
        what = (
            f"has {len(pictures)} pictures and {len(images)} depth images, of which {len(pairs)} have the same number."
        )
        mend = "give a picture and its depth the same number, or write rgb.txt and depth.txt with times as TUM does"
        raise InputError(path, what, mend, code="E-RECORDING-LAYOUT")
    return pairs


def _number_files(files: list[Path], part: slice) -> dict[tuple[int, ...], Path]:
    """Files by a part of the numbers in their names; empty if two have the same."""
    numbered = {tuple(map(int, re.findall(r"\d+", file.stem)[part])): file for file in files}
    return numbered if len(numbered) == len(files) else {}


def _list_files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files in the order of the frames."""
    found = [file for file in folder.iterdir() if file.suffix.lower() in suffixes]
    return sorted(found, key=lambda file: (len(file.stem), file.stem))  # 10 after 9
