"""The frames of an RGB-D recording: which of a folder's files belong together.

Two layouts: TUM's lists of time stamps, and folders of color and depth with the same numbers and a file of intrinsics
(Open3D, RealSense, Record3D's export as EXR and JPG, Stray Scanner once its video is cut into pictures).
docs/your-data.md says how to bring others into the second one.
"""

import os.path
import re
import shlex
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from roomkin.stages.contracts.arrays import explain_unreadable
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import decode_file

COLOR = ("color", "rgb", "image", "colour")  # what pictures, and folders of them, are called besides depth
PICTURES = (".png", ".jpg", ".jpeg", ".ppm")
VIDEOS = (".mp4", ".mov")
DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FILES = (*DEPTH_IMAGES, ".exr", ".npz", ".npy")


def name_picture(path: Path) -> str:
    """What a picture is called: as its file; empty, where the pictures of all recordings are called so."""
    return "" if path.stem.lower() in COLOR else path.stem


def list_frames(path: Path) -> list[tuple[Path, Path]]:
    """Color and depth of every frame of a recording, in its order.

    Raises:
        InputError: no known layout, or a broken one.
    """
    if is_tum(path):
        return _list_of_tum(path)
    if folders := list_folders(path):
        return _pair_files(path, *folders)
    if videos := sorted(file for file in path.glob("*") if file.suffix.lower() in VIDEOS and (path / "depth").is_dir()):
        what, folder = f"has its pictures in a video, {videos[0].name}.", shlex.quote(str(path / "rgb"))
        cut = f"ffmpeg -i {shlex.quote(str(videos[0]))} -vsync 0 -start_number 0 {folder}/%06d.png"
        raise InputError(path, what, f"cut it into pictures: mkdir {folder}; {cut}", code="E-RECORDING-VIDEO")
    what = "is no recording that is known (TUM, Open3D, RealSense, Record3D, Stray Scanner)."
    fix = "folders color and depth with intrinsics.json, or --rgb and --depth"
    raise InputError(path, what if path.exists() else "no such folder.", fix, code="E-RECORDING-LAYOUT")


def list_folders(path: Path) -> tuple[list[Path], list[Path]] | None:
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


def is_tum(path: Path) -> bool:
    return (path / "rgb.txt").is_file() and (path / "depth.txt").is_file()


def _list_of_tum(path: Path) -> list[tuple[Path, Path]]:
    """Every picture of TUM with the depth image nearest in time, 20 ms apart at most (its associate.py).

    Raises:
        InputError: there is none, a list is broken, or it names a file outside of the recording.
    """
    with explain_unreadable(path / "rgb.txt", "list of a TUM recording"):
        colors = _read_stamps(path / "rgb.txt")
        depths = sorted(_read_stamps(path / "depth.txt"), key=lambda one: one[0])
    pairs = list[tuple[Path, Path]]()
    if colors and depths:
        stamps, times = (np.array([stamp for stamp, _ in listed]) for listed in (colors, depths))
        after = np.searchsorted(times, stamps).clip(max=len(times) - 1)
        before = (after - 1).clip(min=0)
        nearest = np.where(np.abs(times[before] - stamps) <= np.abs(times[after] - stamps), before, after)
        close = np.abs(times[nearest] - stamps) <= 0.02
        pairs = [(colors[k][1], depths[nearest[k]][1]) for k in np.flatnonzero(close)]
    if not pairs:
        what = "no picture of its rgb.txt has a depth image of its depth.txt within 20 ms."
        raise InputError(path, what, "give both the times of one clock, in seconds", code="E-RECORDING-LAYOUT")
    return pairs


def _read_stamps(path: Path) -> list[tuple[float, Path]]:
    """Times and files of a list."""
    lines = [line.split() for line in decode_file(path).splitlines() if line.strip() and not line.startswith("#")]
    for _, name, *_ in lines:
        if f"{os.path.normpath(name)}/".startswith(("/", "../")):
            what = f"names '{name[:200]}', which is outside of the recording."
            raise InputError(path, what, "copy it inside", code="E-FILE-OUTSIDE")
    return [(float(stamp), path.parent / name) for stamp, name, *_ in lines]


def _pair_files(path: Path, pictures: list[Path], images: list[Path]) -> list[tuple[Path, Path]]:
    """Pictures with the depth images of the same numbers: all of a name's, or the first or last, whichever pairs most.

    Raises:
        InputError: the numbers pair less than half of them.
    """
    pairs: list[tuple[Path, Path]] = []
    for part in (slice(None), slice(0, 1), slice(-1, None)):
        colors, depths = (_number_files(files, part) for files in (pictures, images))
        # By ffmpeg, and by a phone.
        if len(colors) == len(depths) and _counts_from(1, colors) and _counts_from(0, depths):
            colors = {(number - 1,): file for (number,), file in colors.items()}
        pairs = max(pairs, [(colors[number], depths[number]) for number in colors if number in depths], key=len)
    if not pairs or 2 * len(pairs) < min(len(pictures), len(images)):
        sides = f"{len(pictures)} pictures and {len(images)} depth images"
        what = f"has {sides}, of which {len(pairs)} have the same number."
        mend = "give a picture and its depth the same number, or write rgb.txt and depth.txt with times as TUM does"
        raise InputError(path, what, mend, code="E-RECORDING-LAYOUT")
    return pairs


def _number_files(files: list[Path], part: slice) -> dict[tuple[int, ...], Path]:
    """Files by a part of the numbers in their names; empty if two have the same."""
    numbered = {tuple(map(int, re.findall(r"\d+", file.stem)[part])): file for file in files}
    return numbered if len(numbered) == len(files) else {}


def _counts_from(first: int, numbered: dict[tuple[int, ...], Path]) -> bool:
    """Whether files are numbered without a gap from a number on."""
    return set(numbered) == {(first + k,) for k in range(len(numbered))}


def _list_files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files in the order of the frames."""
    found = [file for file in folder.iterdir() if file.suffix.lower() in suffixes]
    return sorted(found, key=lambda file: (len(file.stem), file.stem))  # 10 after 9


FIELD_OF_VIEW = 5, 135  # degrees over a picture's width: least and largest that are believed
DegreesWide = Annotated[float, Field(ge=FIELD_OF_VIEW[0], le=FIELD_OF_VIEW[1])]

# Fields of view of color cameras in degrees, width and height, by their makers. Pictures that are narrower than the
# sensor are taken to be cut at the sides, wider ones above and below.
FIELDS_OF_VIEW = {
    "azure_kinect": (90.0, 74.3), "kinect_v1": (62.0, 48.6), "kinect_v2": (84.1, 53.8), "realsense_d415": (69.4, 42.5),
    "realsense_d435": (69.4, 42.5), "realsense_d455": (90.0, 65.0), "realsense_l515": (70.0, 43.0),
    "xtion": (58.0, 45.0),
}  # fmt: skip
