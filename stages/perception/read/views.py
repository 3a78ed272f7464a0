"""Read one RGB-D view: picture, depth, camera and masks; upright, straight and at one size; from the files alone."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from roomkin.stages.config.recordings import COLOR, is_tum, list_folders, list_frames
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.hand import digest_of_image
from roomkin.stages.contracts.images import DOWN, TURN, check_shown, check_turned, read_rgb
from roomkin.stages.geometry.depth_forms import along_axis, find_flatter
from roomkin.stages.geometry.frames import back_project, make_intrinsics, scale_intrinsics
from roomkin.stages.geometry.room_planes import fit_floor
from roomkin.stages.perception.read.camera_files import KNOWS
from roomkin.stages.perception.read.cameras import check_intrinsics, intrinsics_of_camera, intrinsics_of_view
from roomkin.stages.perception.read.depth_files import convert_to_metres, read_raw, remove_unsure
from roomkin.stages.perception.read.depth_scale import find_stated_units
from roomkin.stages.perception.read.frame import TILT, Frame, check_upright, doubt_depth, fit_frame, surface_of
from roomkin.stages.perception.read.lens import Lens, read_lens, straighten_frame
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.perception.read.mask_pieces import doubt_surfaces, split_values
from roomkin.stages.perception.read.mask_shapes import list_remarks

CameraReader = Callable[[int, int, str], Lens]  # the camera of a picture of this width, height and file name
# Besides those with `intrinsic` in the name.
CAMERA_FILES = ("camera_matrix.csv", "camera.json", "config.json", "metadata.json", "metadata")


@dataclass(frozen=True)
class ViewFiles:
    """The files of one view.

    color, depth: its pictures. camera: what reads it. unit_file: which may state the unit of the depth. usual: the
    number that stands for one metre where nobody states it. notes: for the log, which frame it is, whose intrinsics.
    confidence: how sure each number of the depth is.
    """

    color: Path
    depth: Path
    camera: CameraReader
    unit_file: Path | None = None
    usual: float | None = None
    notes: tuple[str, ...] = ()
    confidence: Path | None = None


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


def read_frame(view: ViewFiles, unit: str, depth_is: str, masks: Path | None, labels: Path | None) -> Frame:
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
    raw, unsure = read_raw(view.depth), ""
    if view.confidence is not None:
        raw, unsure = remove_unsure(raw, view.confidence)
    depth, line = convert_to_metres(view.depth, raw, unit, find_stated_units(view.depth, view.unit_file), view.usual)
    shown = (rgb.shape[1], rgb.shape[0], view.color.name)
    lens = view.camera(*shown)
    labelled = None if masks is None else read_labelled(masks, labels, *shown)
    notes = [*view.notes[:1], line, *filter(None, [unsure]), *view.notes[1:]]
    frame = Frame(rgb, depth, lens.intrinsics, labelled, notes, digest=digest_of_image(view.color))
    frame = straighten_frame(fit_frame(frame), lens.distortion)
    if labelled is not None and frame.masks is not None:
        kept = set(np.unique(frame.masks.values).tolist())
        if lost := [(name, "has no pixels") for value, name in labelled.labels.items() if value not in kept]:
            left = f"{len(labelled.labels) - len(lost)} of {len(labelled.labels)}"
            print(f"{masks}: made straight and fitted, {left} are left: {list_remarks(lost)}")
    if depth_is == "ray":
        frame = replace(frame, depth=along_axis(frame.depth, frame.intrinsics))
    doubts = []
    if flatter := find_flatter(frame.depth, frame.intrinsics):
        form = "ray" if flatter == "ray" else "z"
        doubts = [f"depth in doubt: floor and walls would be flat with --depth-is {form}"]
    doubts.append(doubt_depth(frame.depth, frame.rgb, None if frame.masks is None else frame.masks.values))
    for doubt in filter(None, doubts):
        print(f"{view.depth}: {doubt}")
    check_floor(frame)
    frame = replace(frame, doubt="; ".join(filter(None, doubts)))
    return frame if frame.masks is None else doubt_surfaces(split_values(frame))


def check_floor(frame: Frame) -> None:
    """Refuse a frame that is upside down with its depth and masks.

    Raises:
        InputError: what is called floor is above the camera, or nothing level faces up.
    """
    points, known = back_project(frame.depth.astype(float), frame.intrinsics), frame.depth > 0
    floors = [value for value, name in frame.masks.labels.items() if surface_of(name) == "floor"] if frame.masks else []
    if floors:
        assert frame.masks is not None
        named = points[known & np.isin(frame.masks.values, floors)]
        floor = fit_floor(named, TILT, np.random.default_rng(0))
        if floor is not None and floor.offset > 0:
            what = "is upside down: what is called floor lies above the camera."
            raise InputError("the picture", what, TURN, code=DOWN)
    else:
        check_turned("the picture", points, known, TILT)


def find_view(path: Path, number: int, camera: CameraReader | None, camera_file: Path | None = None) -> ViewFiles:
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
    if is_tum(path):
        source = [] if camera else ["intrinsics of TUM's tools"]
        all_three = make_intrinsics(525.0, 525.0, 319.5, 239.5)  # as they have it for pictures of 640 x 480
        known = camera or (lambda width, height, _: Lens(scale_intrinsics(all_three, width / 640, height / 480)))
        return ViewFiles(color, depth, known, camera_file, 5000.0, (f"TUM, {color.name}", *source))
    pictures, images = list_folders(path) or ([], [])
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
    notes += ["odometry.csv is not read, as one frame needs no path"] if (path / "odometry.csv").is_file() else []
    of_depth = (path / "confidence" / f"{depth.stem}{suffix}" for suffix in (".png", ".npy"))
    confidence = next((file for file in of_depth if file.is_file()), None)
    return ViewFiles(color, depth, camera, camera_file or next(iter(own), None), None, tuple(notes), confidence)


def _list_camera_files(path: Path) -> list[Path]:
    """The recording's files of intrinsics: those that say color, else all that say intrinsics, else one called so."""
    own = [one for one in sorted(path.iterdir()) if one.is_file() and "intrinsic" in one.name.lower()]
    own = [one for one in own if set(re.findall("[a-z]+", one.stem.lower())) & set(COLOR)] or own
    return own or [path / name for name in CAMERA_FILES if (path / name).is_file()][:1]
