"""What the page about one picture adds to the report: camera, depth, doubts, files to save."""

import os
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from plugins.report.album import Album, Picture
from plugins.report.doubts import group_doubts
from plugins.report.page.files import RunFiles
from plugins.report.page.rooms import RebuiltScene, Reconstruction, RoomPart
from stages.contracts.doubt import Doubt, DoubtKind
from stages.contracts.extracted import read_metres
from stages.contracts.files import read_json
from stages.contracts.objects import Objects
from stages.contracts.scenes import Camera

MOST = 5  # doubts that the page shows in full; chosen


@dataclass(frozen=True)
class InputFacts:
    """Facts on camera and room, the depth as a picture with its caption."""

    facts: list[tuple[str, str]]
    depth: Picture | None
    range: str


def input_facts(files: RunFiles, name: str, camera: Path, album: Album) -> InputFacts:
    """What is known of the camera and the room."""
    path = files.find_first(f"extraction/{name}/objects.json")
    note = read_json(Camera, camera).note
    if path is None:
        return InputFacts([], None, "")
    objects = read_json(Objects, path)
    facts = camera_facts(objects)
    if note:
        facts.append(("how it is known", note))
    at = f", nearest {min(abs(wall.offset) for wall in objects.walls):.1f} m from the camera" if objects.walls else ""
    facts.append(("walls", f"{len(objects.walls)}{at}"))
    depth = read_metres(path, objects)
    if depth is None or not (depth > 0).any():
        return InputFacts(facts, None, "")
    near, far = (float(np.quantile(depth[depth > 0], share)) for share in (0.01, 0.99))
    picture = album.put(Image.fromarray(colour_depth(depth, near, far)), "Distance of what the picture shows")
    return InputFacts(facts, picture, f"Distance: dark {near:.1f} m, bright {far:.1f} m, black unknown")


def camera_facts(objects: Objects) -> list[tuple[str, str]]:
    """Focal length, height and tilt."""
    focal, width = objects.intrinsics[0][0], objects.width
    across = np.degrees(2 * np.arctan(width / 2 / focal))
    pose = np.array(objects.floor_from_camera)
    down, roll = -np.degrees(np.arcsin(pose[2, 2])), np.degrees(np.arctan2(pose[2, 0], -pose[2, 1]))
    tilt = f"tilted {'down' if down >= 0 else 'up'} by {abs(down):.0f}°"
    if abs(roll) >= 0.5:
        tilt += f", rolled by {abs(roll):.0f}°"
    return [
        ("picture", f"{width} × {objects.height} pixels"),
        ("lens", f"{across:.0f}° across (focal length {focal:.0f} pixels)"),
        ("camera", f"{pose[2, 3]:.2f} m above the floor, {tilt}"),
    ]


def colour_depth(depth: NDArray[np.float32], near: float, far: float) -> NDArray[np.uint8]:
    """Depth (H, W) as colours, black where it is unknown."""
    share = np.clip((depth - near) / max(far - near, 1e-6), 0, 1)
    colours = cv2.applyColorMap((255 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    return np.where(depth[..., None] > 0, colours, 0).astype(np.uint8)


def links(files: RunFiles, name: str, page: Path) -> dict[str, str]:
    """The scenes (GLB), and what the stages found (JSON): name -> link from the page."""
    patterns = [f"generation/*/{name}/scene_*.glb", f"extraction/{name}/objects.json"]
    patterns += [f"matching/*/{name}/cousins.json", f"generation/*/{name}/scene_*.json"]
    paths = [path for pattern in patterns for path in files.find_all(pattern)]
    return {"/".join(path.parts[-4:]): quote(os.path.relpath(path, page.parent)) for path in paths}


class Listed(NamedTuple):
    """Doubts of one cause: what helps; then for each object the doubt and the command that opens it (or nothing)."""

    title: str
    mend: str
    entries: list[tuple[str, str, str]]


def doubts(room: RoomPart, rebuilt: Reconstruction | None) -> list[Listed]:
    """Doubts that a person can mend, gravest first: the camera, what failed, then by cause."""
    correct = rebuilt.correct if rebuilt else ""
    failed = [
        (f"{one} failed in {stage}", reason, correct and correct + one)
        for one, (stage, reason) in room.failures.items()
    ]
    found = [("camera", room.camera_doubt)] if room.camera_doubt else []
    found += [(match.entry.id, doubt) for match in (rebuilt.matches if rebuilt else []) for doubt in match.doubts]
    found += doubt_physics(rebuilt.scenes if rebuilt else [])
    objects = {match.entry.id for match in rebuilt.matches} if rebuilt else set()
    listed = [Listed("Failed", "name or draw it again on the correction page", failed)] if failed else []
    groups = [*listed, *_group_doubts(found, correct, objects)]
    return sorted(groups, key=lambda group: group.title != "Camera")  # what is wrong with the camera makes all wrong


def doubt_physics(scenes: list[RebuiltScene]) -> list[tuple[str, Doubt]]:
    """Which scenes do not stay as they were put, and why; those that have the same fault together."""
    ranks: dict[str, list[str]] = {}
    for scene in scenes:
        if scene.stands is False:
            ranks.setdefault(scene.wrong, []).append(str(scene.rank))
    about = {what: f"scene{'s'[: len(which) > 1]} of rank {', '.join(which)}" for what, which in ranks.items()}
    return [(about[what], DoubtKind.UNSTABLE.of(what=what)) for what in ranks]


class Grave(NamedTuple):
    """One of the gravest doubts: about what, the doubt, what helps, and the command that opens it (or nothing)."""

    about: str
    what: str
    mend: str
    command: str


def split_doubts(listed: list[Listed]) -> tuple[list[Grave], list[Listed]]:
    """The gravest doubts, one by one, and the others by their causes."""
    first: list[Grave] = []
    rest: list[Listed] = []
    for group in listed:
        room = MOST - len(first)
        first += [Grave(about, what, group.mend, command) for about, what, command in group.entries[:room]]
        if more := group.entries[room:]:
            rest.append(group._replace(entries=more))
    return first, rest


def _group_doubts(found: list[tuple[str, Doubt]], correct: str, objects: Collection[str]) -> list[Listed]:
    """Doubts by cause; `correct`: the command, up to an object's id, that opens the page to correct it."""
    return [
        Listed(
            group.cause.capitalize(),
            group.mend,
            [
                (about.replace("_", " "), what, correct + about if correct and about in objects else "")
                for about, what in group.items
            ],
        )
        for group in group_doubts(found)
    ]


def list_further_doubts(rebuilt: Reconstruction | None) -> list[tuple[list[int], list[Listed]]]:
    """Further doubts of other ranks: ranks, and the doubts that all their scenes share beyond those of rank 1."""
    alike: dict[tuple[tuple[str, Doubt], ...], list[int]] = {}
    for scene in rebuilt.scenes if rebuilt else []:
        alike.setdefault(tuple(scene.doubts), []).append(scene.rank)
    correct = rebuilt.correct if rebuilt else ""
    return [(ranks, _group_doubts([*found], correct, dict(found))) for found, ranks in alike.items() if found]


def notes(rebuilt: Reconstruction | None) -> list[tuple[str, str]]:
    """Notes by object that need no action."""
    return [
        (match.entry.id.replace("_", " "), note)
        for match in (rebuilt.matches if rebuilt else [])
        for note in match.notes
    ]
