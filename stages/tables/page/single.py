"""What the page about one picture says beyond what the report says of a room: camera, depth, doubts, files to save."""

import base64
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from stages.contracts.cousins import Cousins
from stages.contracts.extracted import read_metres
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene
from stages.contracts.made import Made
from stages.contracts.objects import Objects
from stages.contracts.scenes import Camera
from stages.tables.page.files import RunFiles
from stages.tables.page.pictures import Album, Picture
from stages.tables.page.rooms import Reconstruction, RoomPart

SAVED = 4_000_000  # bytes of files inside the page; what does not fit is named by its path
KINDS = {".glb": "model/gltf-binary", ".json": "application/json"}


@dataclass(frozen=True)
class Download:
    """A file to save; without `source` it is only named."""

    name: str
    what: str
    size: str
    source: str


@dataclass(frozen=True)
class Found:
    """Facts on camera and room, the depth as a picture with its caption."""

    facts: list[tuple[str, str]]
    depth: Picture | None
    range: str


def found(files: RunFiles, name: str, camera: Path, album: Album) -> Found:
    """What is known of the camera and the room."""
    path = files.one(f"extraction/{name}/objects.json")
    note = read_json(Camera, camera).note
    if path is None:
        return Found([], None, "")
    objects = read_json(Objects, path)
    facts = camera_facts(objects)
    if note:
        facts.append(("how it is known", note))
    at = f", nearest {min(abs(wall.offset) for wall in objects.walls):.1f} m from the camera" if objects.walls else ""
    facts.append(("walls", f"{len(objects.walls)}{at}"))
    depth = read_metres(path, objects)
    if depth is None or not (depth > 0).any():
        return Found(facts, None, "")
    near, far = (float(np.quantile(depth[depth > 0], share)) for share in (0.01, 0.99))
    picture = album.put(Image.fromarray(coloured(depth, near, far)), "Distance of what the picture shows", album.width)
    return Found(facts, picture, f"Distance: dark {near:.1f} m, bright {far:.1f} m, black unknown")


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


def coloured(depth: NDArray[np.float32], near: float, far: float) -> NDArray[np.uint8]:
    """Depth (H, W) as colours, black where it is unknown."""
    share = np.clip((depth - near) / max(far - near, 1e-6), 0, 1)
    colours = cv2.applyColorMap((255 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    return np.where(depth[..., None] > 0, colours, 0).astype(np.uint8)


def downloads(files: RunFiles, name: str) -> list[Download]:
    """The scenes as GLB, and what the stages say of the picture as JSON."""
    said = {"objects.json": "what was found", "cousins.json": "cousins of every object"}
    paths = [*files.all(f"generation/*/{name}/scene_*.glb"), *files.all(f"extraction/{name}/objects.json")]
    paths += [*files.all(f"matching/*/{name}/cousins.json"), *files.all(f"generation/*/{name}/scene_*.json")]
    made, left = [], SAVED
    for path in paths:
        size = path.stat().st_size
        rank = path.stem.removeprefix("scene_")
        what = said.get(path.name) or f"scene of rank {rank}" + ("" if path.suffix == ".glb" else ", places and sizes")
        source = ""
        if size <= left:
            left -= size
            source = f"data:{KINDS[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
        made.append(
            Download(f"{name}_{path.name}" if source else str(path), what, f"{max(1, round(size / 1000))} kB", source)
        )
    return made


def origins(files: RunFiles, name: str) -> list[tuple[str, Made]]:
    """What objects, cousins and scenes of rank 1 were made of, as far as the files say so."""
    kinds: list[tuple[type[Objects | Cousins | GeneratedScene], str]] = [
        (Objects, f"extraction/{name}/objects.json"),
        (Cousins, f"matching/*/{name}/cousins.json"),
        (GeneratedScene, f"generation/*/{name}/scene_1.json"),
    ]
    found = [(path, read_json(kind, path).made) for kind, pattern in kinds for path in files.all(pattern)]
    return [("/".join(path.parts[-3:]), made) for path, made in found if made is not None]


def doubts(room: RoomPart, made: Reconstruction | None) -> list[tuple[str, str, str]]:
    """What should not be taken for certain: the object or scene that it is about, the doubt, what opens the page on
    which that object is corrected (empty: nothing does)."""
    mend = made.mend if made else ""
    told = [
        (f"{one} failed in {stage}", reason or "no reason given", mend and mend + one)
        for one, stage, reason in room.failures
    ]
    if made is None:
        return told
    for match in made.matches:
        found = match.story.doubts if match.story else []
        told += [(match.id.replace("_", " "), doubt, mend and mend + match.id) for doubt in found]
    told += [(f"scene of rank {scene.rank}", scene.physics, "") for scene in made.scenes if scene.steady is False]
    return told
