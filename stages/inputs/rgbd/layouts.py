"""Frames of RGB-D recordings and data sets as they lie on disk: which of a folder's files belong together.

TUM RGB-D, Open3D and RealSense recordings, Record3D (iPhone, iPad), NYU Depth v2 (labelled .mat), SUN RGB-D.
"""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stages.contracts import InputError
from stages.contracts.arrays import readable
from stages.contracts.images import read_rgb
from stages.inputs.rgbd.cameras import Matrix, checked, matrix, of_mapping, read_intrinsics, resized
from stages.inputs.rgbd.depth_files import FILES, in_metres, read_raw
from stages.inputs.rgbd.frame import Frame, Labelled
from stages.inputs.rgbd.lens import find_distortion
from stages.inputs.rgbd.mask_files import polygon, stacked

PICTURES = (".png", ".jpg", ".jpeg", ".ppm")
TUM_PER_METRE, TUM_APART = "5000", 0.02  # seconds between colour and depth of one frame
TUM = {
    "freiburg1": (517.3, 516.5, 318.6, 255.3),
    "freiburg2": (520.9, 521.0, 325.1, 249.7),
    "freiburg3": (535.4, 539.2, 320.1, 247.6),
}
TUM_OTHERS = (525.0, 525.0, 319.5, 239.5)
NYU = (518.857901, 519.469611, 325.582449, 253.736166)  # colour camera, by the toolbox of the data set
SUN_FARTHEST = 8.0  # metres: what is beyond is unknown
CONFIDENT = 2  # of Record3D's 0 (poor), 1, 2


def read_frame(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    """Frame `number`, from 0, of a recording.

    Args:
        path: folder of the recording, or its file (.mat, .r3d).
        number: of the frame, in the order of the recording.
        intrinsics: what to use in the place of the recording's own: (width, height) -> K.

    Raises:
        InputError: no known layout, no such frame, or a broken one.
    """
    readers: list[tuple[bool, Callable[..., Frame]]] = [
        (path.suffix.lower() == ".mat", _nyu),
        (path.suffix.lower() == ".r3d", _record3d),
        ((path / "metadata.json").is_file() or (path / "metadata").is_file(), _record3d),
        ((path / "intrinsics.txt").is_file() and (path / "image").is_dir(), _sun),
        ((path / "depth.txt").is_file() and (path / "rgb.txt").is_file(), _tum),
        (_open3d_folders(path) is not None, _open3d),
    ]
    reader = next((reader for fits, reader in readers if fits), None)
    if reader is None:
        what = "is no recording that is known (TUM, Open3D, RealSense, Record3D, NYU, SUN)."
        raise InputError(path, what if path.exists() else "no such file or folder.", "or give --rgb and --depth")
    return reader(path, number, intrinsics)


def _frame(files: list[Path], number: int, where: Path) -> Path:
    if not 0 <= number < len(files):
        raise InputError("--number", f"{where} has {len(files)} frames, counted from 0: there is no {number}.")
    return files[number]


def _files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    found = [file for file in folder.iterdir() if file.suffix.lower() in suffixes]
    return sorted(found, key=lambda file: (len(file.stem), file.stem))  # 10 after 9


def _stamps(path: Path) -> list[tuple[float, Path]]:
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    return [(float(stamp), path.parent / name) for stamp, name, *_ in lines]


def _tum(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    with readable(path / "rgb.txt", "list of a TUM recording"):
        colours, depths = _stamps(path / "rgb.txt"), _stamps(path / "depth.txt")
        times = np.array([stamp for stamp, _ in depths])
        nearest = [int(np.abs(times - stamp).argmin()) for stamp, _ in colours]
        pairs = {
            colour: depths[k][1]
            for (stamp, colour), k in zip(colours, nearest, strict=True)
            if abs(times[k] - stamp) <= TUM_APART
        }
    colour = _frame(list(pairs), number, path)
    rgb = read_rgb(colour)
    depth, line = in_metres(pairs[colour], read_raw(pairs[colour]), TUM_PER_METRE)
    name = next((name for name in TUM if name in str(path.resolve()).lower()), None)
    own = matrix(*TUM.get(name or "", TUM_OTHERS))
    own = resized(own, rgb.shape[1] / 640, rgb.shape[0] / 480)
    which = f"of {name}" if name else "TUM's default"
    return Frame(rgb, depth, _chosen(intrinsics, own, rgb), None, [f"TUM, {colour.name}", line, f"intrinsics {which}"])


def _open3d_folders(path: Path) -> tuple[Path, Path] | None:
    for colour in ("color", "rgb", "image", "colour"):
        if (path / colour).is_dir() and (path / "depth").is_dir():
            return path / colour, path / "depth"
    return None


def _open3d(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    """Open3D's and RealSense's recorders: color/, depth/ with the same order, camera_intrinsic.json or the like."""
    colour_folder, depth_folder = _open3d_folders(path) or (path, path)
    colours, depths = _files(colour_folder, PICTURES), _files(depth_folder, FILES)
    if len(colours) != len(depths):
        raise InputError(path, f"has {len(colours)} pictures, but {len(depths)} depth images.")
    rgb = read_rgb(_frame(colours, number, path))
    depth, line = in_metres(depths[number], read_raw(depths[number]))
    height, width = rgb.shape[:2]
    notes = [f"Open3D or RealSense, {colours[number].name} and {depths[number].name}", line]
    if intrinsics is not None:
        return Frame(rgb, depth, intrinsics(width, height), None, notes)
    names = [file for file in sorted(path.iterdir()) if file.is_file() and "intrinsic" in file.name.lower()]
    names += [file for file in (path / "camera.json", path / "config.json") if file.is_file()]
    if not names:
        raise InputError(path, "has no file of intrinsics.", "give --intrinsics, --camera or --fov")
    own = read_intrinsics(names[0], width, height)
    notes.append(f"intrinsics of {names[0].name}")
    return Frame(rgb, depth, own, None, notes, find_distortion(names[0], own, width, height))


def _record3d(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    """Exports of Record3D: a folder of JPEG and EXR, or an .r3d file (a ZIP of JPEG and LZFSE)."""
    if path.suffix.lower() == ".r3d":
        rgb, depth, about = _r3d_frame(path, number)
    else:
        name = path / "metadata.json" if (path / "metadata.json").is_file() else path / "metadata"
        with readable(name, "JSON file"):
            about = json.loads(name.read_text(encoding="utf-8"))
        colours = path / "rgb" if (path / "rgb").is_dir() else path / "rgbd" if (path / "rgbd").is_dir() else path
        depths = path / "depth" if (path / "depth").is_dir() else colours
        colour = _frame(_files(colours, PICTURES), number, path)
        file = next((found for suffix in FILES if (found := depths / f"{colour.stem}{suffix}").is_file()), None)
        if file is None:
            packed = depths / f"{colour.stem}.depth"
            if not packed.is_file():
                raise InputError(path, f"has no depth for {colour.name}.")
            raw = _unpacked(packed, packed.read_bytes(), about)
        else:
            raw = read_raw(file)
        rgb, depth = read_rgb(colour), raw
    metres, line = in_metres(path, depth, "m")
    each = about.get("perFrameIntrinsicCoeffs") or []
    with readable(path, "metadata of Record3D"):
        own = matrix(*map(float, each[number][:4])) if number < len(each) else of_mapping(path, about)[0]
        width, height = float(about["w"]), float(about["h"])
    own = resized(own, rgb.shape[1] / width, rgb.shape[0] / height)
    return Frame(rgb, metres, _chosen(intrinsics, own, rgb), None, [f"Record3D, frame {number}", line])


def _r3d_frame(path: Path, number: int) -> tuple[NDArray[np.uint8], NDArray[Any], dict[str, Any]]:
    import io

    from PIL import Image

    with readable(path, "Record3D file"), zipfile.ZipFile(path) as archive:
        about = json.loads(archive.read("metadata"))
        names = [name for name in archive.namelist() if name.startswith("rgbd/") and name.endswith(".jpg")]
        if not 0 <= number < len(names):
            raise InputError("--number", f"{path} has {len(names)} frames, counted from 0: there is no {number}.")
        with Image.open(io.BytesIO(archive.read(f"rgbd/{number}.jpg")), formats=("JPEG",)) as image:
            rgb = np.array(image.convert("RGB"))
        return rgb, _unpacked(path, archive.read(f"rgbd/{number}.depth"), about), about


def _unpacked(path: Path, packed: bytes, about: dict[str, Any]) -> NDArray[np.float32]:
    try:
        import liblzfse
    except ImportError:
        mend = "pip install pyliblzfse, or export as EXR + JPG"
        raise InputError(path, "is packed with LZFSE, which nothing installed here reads.", mend) from None
    values = np.frombuffer(liblzfse.decompress(packed), dtype=np.float32)
    return values.reshape(int(about["dh"]), int(about["dw"]))


def _nyu(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    """nyu_depth_v2_labeled.mat (HDF5): arrays lie turned, as MATLAB writes them."""
    import h5py

    with readable(path, "labelled .mat file of NYU Depth v2"), h5py.File(path, "r") as file:
        count = len(file["images"])
        if not 0 <= number < count:
            raise InputError("--number", f"{path} has {count} frames, counted from 0: there is no {number}.")
        rgb = np.ascontiguousarray(np.transpose(file["images"][number], (2, 1, 0)), dtype=np.uint8)
        raw = np.asarray(file["depths"][number]).T
        names = ["".join(map(chr, np.asarray(file[reference]).ravel())) for reference in file["names"][0]]
        classes, instances = np.asarray(file["labels"][number]).T, np.asarray(file["instances"][number]).T
    depth, line = in_metres(path, raw, "m")
    both = classes.astype(np.int64) * 1000 + instances
    masks = [(names[value // 1000 - 1], both == value) for value in np.unique(both).tolist() if value >= 1000]
    own = matrix(*NYU)
    return Frame(rgb, depth, _chosen(intrinsics, own, rgb), stacked(path, masks), [f"NYU, frame {number}", line])


def _sun(path: Path, number: int, intrinsics: Callable[[int, int], Matrix] | None) -> Frame:
    """One folder of SUN RGB-D: its depth images have their three lowest bits in front."""
    picture = _frame(_files(path / "image", PICTURES), number, path)
    folder = next((path / name for name in ("depth_bfx", "depth") if (path / name).is_dir()), path / "depth")
    if not folder.is_dir():
        raise InputError(path, "has no folder depth.")
    rgb = read_rgb(picture)
    depth_file = _frame(_files(folder, FILES), number, folder)
    raw = read_raw(depth_file).astype(np.uint16)
    depth, line = in_metres(depth_file, (raw >> 3) | (raw << 13), "mm")
    depth[depth > SUN_FARTHEST] = 0
    height, width = rgb.shape[:2]
    own = read_intrinsics(path / "intrinsics.txt", width, height)
    masks = _sun_masks(path / "annotation2Dfinal" / "index.json", width, height)
    return Frame(rgb, depth, _chosen(intrinsics, own, rgb), masks, [f"SUN RGB-D, {picture.name}", line])


def _sun_masks(path: Path, width: int, height: int) -> Labelled | None:
    if not path.is_file():
        return None
    with readable(path, "annotation of SUN RGB-D"):
        data = json.loads(path.read_text(encoding="utf-8", errors="replace"))
        names = [str(item["name"]) if item else "" for item in data["objects"]]
        masks = []
        for item in data["frames"][0]["polygon"]:
            corners = np.stack([np.atleast_1d(item["x"]), np.atleast_1d(item["y"])], axis=1)
            masks.append((names[item["object"]].split(":")[0], polygon(corners, width, height)))
    return stacked(path, masks)


def _chosen(intrinsics: Callable[[int, int], Matrix] | None, own: Matrix, rgb: NDArray[np.uint8]) -> Matrix:
    height, width = rgb.shape[:2]
    return (
        checked("intrinsics of the recording", own, width, height) if intrinsics is None else intrinsics(width, height)
    )
