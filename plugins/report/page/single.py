"""Additions to the report for one picture: camera, depth, doubts, files to save."""

import math
import os
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from roomkin.plugins.report.album import Album, PagePicture
from roomkin.plugins.report.doubts import measure_side
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.rooms import RebuiltScene, Reconstruction, RoomPart
from roomkin.stages.contracts.doubt import MEND, Doubt, DoubtKind
from roomkin.stages.contracts.errors import count
from roomkin.stages.contracts.extracted import read_metres
from roomkin.stages.contracts.objects import Objects
from roomkin.stages.contracts.scenes import Camera
from roomkin.stages.extraction.floor import doubt_unit


class CameraFacts(NamedTuple):
    """Focal length in pixels, degrees across, height in metres, degrees by which it is tilted down and rolled."""

    focal: float
    across: float
    height: float
    down: float
    roll: float


def measure_camera(objects: Objects) -> CameraFacts:
    """The pose of the camera and its field of view."""
    focal, pose = objects.intrinsics[0][0], np.array(objects.floor_from_camera)
    across = np.degrees(2 * np.arctan(objects.width / 2 / focal))
    down, roll = -np.degrees(np.arcsin(pose[2, 2])), np.degrees(np.arctan2(pose[2, 0], -pose[2, 1]))
    return CameraFacts(focal, float(across), float(pose[2, 3]), float(down), float(roll))


def draw_depth(path: Path, objects: Objects, album: Album) -> tuple[PagePicture, float, float] | None:
    """Depth beside objects.json as a picture, with the nearest and the farthest distance; None where none is known."""
    depth = read_metres(path, objects)
    if depth is None or not (depth > 0).any():
        return None
    near, far = (float(np.quantile(depth[depth > 0], share)) for share in (0.01, 0.99))
    picture = Image.fromarray(color_depth(depth, near, far))
    return album.put(picture, "Distance of what the picture shows"), near, far


def color_depth(depth: NDArray[np.float32], near: float, far: float) -> NDArray[np.uint8]:
    """Depth (H, W) as colors, black where it is unknown."""
    share = np.clip((depth - near) / max(far - near, 1e-6), 0, 1)
    colors = cv2.applyColorMap((255 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    return np.where(depth[..., None] > 0, colors, 0).astype(np.uint8)


def links(files: RunFiles, name: str, page: Path) -> dict[str, str]:
    """The scenes (GLB), and what the stages found (JSON): name -> link from the page."""
    patterns = [f"generation/*/{name}/scene_*.glb", f"extraction/{name}/objects.json"]
    patterns += [f"matching/*/{name}/cousins.json", f"generation/*/{name}/scene_*.json"]
    paths = [path for pattern in patterns for path in files.find_all(pattern)]
    return {"/".join(path.parts[-4:]): quote(os.path.relpath(path, page.parent)) for path in paths}


class Listed(NamedTuple):
    """A doubt: its cause, what helps, about what it is, and the command that opens it (or nothing)."""

    cause: str
    mend: str
    about: str
    what: str
    command: str


def doubt_camera(camera: Camera, objects: Objects | None) -> list[Doubt]:
    """What is doubtful about depth, as its reading told, its unit, and a tilt that nobody gave or holds a camera by."""
    found = [DoubtKind.DEPTH.read(Doubt(cause="camera", what=one)) for one in camera.note.split("; ") if one]
    doubts = [DoubtKind.DEPTH.of(**values) for values in found if values]
    if objects is not None and (unit := doubt_unit(objects.objects)):
        doubts.append(DoubtKind.UNIT.of(what=unit))
    if objects is not None and camera.floor_from_camera is None:
        tilt = float(np.degrees(np.arccos(np.clip(-objects.floor_from_camera[2][1], -1, 1))))
        doubts += [DoubtKind.CAMERA_TILT.of(tilt=tilt)] if tilt > DoubtKind.CAMERA_TILT.threshold else []
    return doubts


def list_doubts(room: RoomPart, rebuilt: Reconstruction | None, camera: Camera) -> list[Listed]:
    """Doubts that a person can mend: depth and camera, what failed, scenes that do not stand, then by harm."""
    height = room.found.camera_doubt
    found = [("camera", doubt) for doubt in [*doubt_camera(camera, room.found.objects), *([height] if height else [])]]
    found += [(match.entry.id, doubt) for match in (rebuilt.matches if rebuilt else []) for doubt in match.doubts]
    found += doubt_physics(rebuilt.scenes if rebuilt else [])
    mend = "name or draw it again on the correction page"
    failed = [
        Listed("Failed", mend, f"{one} failed in {stage}", reason, rebuilt.choose(one) if rebuilt else "")
        for one, (stage, reason) in room.failures.items()
    ]
    listed = [*failed, *_list_by_harm(found, rebuilt)]
    return sorted(listed, key=lambda one: one.cause != "Camera")  # what is wrong with the camera makes all wrong


def tell_doubts(listed: list[Listed]) -> str:
    """How many doubts there are, about how many things."""
    things = len({one.about for one in listed})
    return f"{count(len(listed), 'doubt')} about {count(things, 'thing')}" if listed else "no doubts"


def doubt_physics(scenes: list[RebuiltScene]) -> list[tuple[str, Doubt]]:
    """Which scenes do not stay as they were put, and why; those that have the same fault together."""
    ranks: dict[str, list[str]] = {}
    for scene in (one.scene for one in scenes):
        if scene.plausibility and scene.plausibility.wrong:
            ranks.setdefault(scene.plausibility.wrong, []).append(str(scene.rank))
    return [
        (f"scene{'s'[: len(which) > 1]} of rank {', '.join(which)}", DoubtKind.UNSTABLE.of(what=what))
        for what, which in ranks.items()
    ]


def _list_by_harm(found: list[tuple[str, Doubt]], rebuilt: Reconstruction | None) -> list[Listed]:
    """Doubts by their chance times the size of the thing; those about the camera or a scene concern all its things."""
    sides = {match.entry.id: measure_side(match.item, match.placed) for match in (rebuilt.matches if rebuilt else [])}
    return [
        Listed(
            doubt.cause.capitalize(), MEND[doubt.cause], about.replace("_", " "), doubt.what,
            rebuilt.choose(about) if rebuilt and about in sides else "",
        )
        for about, doubt in sorted(found, key=lambda one: -one[1].chance * sides.get(one[0], math.inf))
    ]  # fmt: skip


def list_further_doubts(rebuilt: Reconstruction | None) -> list[tuple[list[int], list[Listed]]]:
    """Further doubts of other ranks: ranks, and the doubts that all their scenes share beyond those of rank 1."""
    alike: dict[tuple[tuple[str, Doubt], ...], list[int]] = {}
    for one in rebuilt.scenes if rebuilt else []:
        alike.setdefault(tuple(one.doubts), []).append(one.scene.rank)
    return [(ranks, _list_by_harm([*found], rebuilt)) for found, ranks in alike.items() if found]
