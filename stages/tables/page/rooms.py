"""What the page says of each room: input, reconstructions, failures, plausibility."""

import base64
import gzip
import shlex
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from stages.contracts.cousins import Cousins
from stages.contracts.extracted import read_clouds, read_object_masks
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene
from stages.contracts.images import read_rgb
from stages.contracts.objects import Objects
from stages.contracts.snapshot_pictures import Snapshots
from stages.tables.order import natural, title
from stages.tables.page.cousins import Match, matches
from stages.tables.page.files import RunFiles
from stages.tables.page.pictures import Album, Picture
from stages.tables.page.stories import Evidence
from stages.tables.table2 import judge


@dataclass(frozen=True)
class RebuiltScene:
    """The scene of one cousin rank; `steady` is None if physics was not asked."""

    rank: int
    picture: Picture | None
    placed: int
    moved: list[str]
    physics: str
    steady: bool | None


@dataclass(frozen=True)
class Reconstruction:
    """A room under one variant; `judge`: who decided on models and orientations."""

    variant: str
    encoder: str
    judge: str
    scenes: list[RebuiltScene]
    matches: list[Match]
    view: str  # the scene of the first rank to turn round, binary glTF, gzip in base64; empty: the run has none
    mend: str  # the command, up to an object's id, that opens the page on which that object is corrected; empty: none

    @property
    def title(self) -> str:
        """Its name, and what compared and decided in this run."""
        told = {"encoder": self.encoder, "judge": self.judge}
        return " · ".join([f"Variant {self.variant}", *(f"{what} {name}" for what, name in told.items() if name)])


@dataclass(frozen=True)
class RoomPart:
    """A room and everything made of it; `failures` are (object, stage, reason)."""

    name: str
    title: str
    input: Picture | None
    overview: Picture | None
    objects: int
    failures: list[tuple[str, str, str]]
    reconstructions: list[Reconstruction]


def _scene(scene: GeneratedScene, picture: Picture | None) -> RebuiltScene:
    check = scene.plausibility
    physics = "not checked"
    if check:
        physics = (
            f"{'stable' if check.stable else f'not stable ({check.wrong})'} after {check.seconds:g} s; "
            f"moved {100 * check.mean_displacement:.1f} cm on average, {check.collisions} collisions, "
            f"deepest penetration {1000 * check.max_penetration:.1f} mm"
        )
    placed = [item for item in scene.objects if item.status == "ok"]
    moved = [f"{item.id} {100 * item.moved:.0f} cm" for item in placed if item.moved > 0.005]
    return RebuiltScene(scene.rank, picture, len(placed), moved, physics, check.stable if check else None)


def _evidence(
    files: RunFiles, room: str, objects: Objects, image: Path | None, first: GeneratedScene | None
) -> Evidence:
    """What the run has to tell the objects' stories with."""
    path = files.one(f"extraction/{room}/objects.json")
    has = {name: path and files.one(f"extraction/{room}/{name}") for name in ("masks.png", "clouds.npz")}
    rgb = read_rgb(image) if image else None
    return Evidence(
        objects,
        rgb if rgb is not None and rgb.shape[:2] == (objects.height, objects.width) else None,
        read_object_masks(path, objects) if path and has["masks.png"] else None,
        read_clouds(path, objects) if path and has["clouds.npz"] else {},
        {item.id: item for item in first.objects} if first else {},
    )


def _packed(path: Path | None) -> str:
    return base64.b64encode(gzip.compress(path.read_bytes(), 9, mtime=0)).decode("ascii") if path else ""


class _Failures:
    """Objects that failed, each told once, where it failed first."""

    def __init__(self) -> None:
        self.told: list[tuple[str, str, str]] = []

    def add(self, stage: str, items: list) -> None:  # type: ignore[type-arg]
        gone = {name for name, *_ in self.told}
        self.told += [(i.id, stage, i.reason) for i in items if i.status == "failed" and i.id not in gone]


def _judge(found: Cousins) -> str:
    """As in Table 2; objects that nobody decided on say nothing."""
    deciders = [(item.decided_by, item.orientation_decided_by) for item in found.objects]
    return judge(pd.DataFrame(deciders, columns=["model_judge", "orientation_judge"]))


def _mend(image: Path | None, scene: str, variant: str) -> str:
    if image is None:
        return ""
    said = ["annotate", str(image.parent), "--scene", scene, "--variant", variant, "--choose"]
    return f"python -m stages.extraction {shlex.join(said)} "


def _room(files: RunFiles, name: str, album: Album, snapshots: Snapshots) -> RoomPart:
    label = title(name)
    path = files.one(f"extraction/{name}/objects.json")
    objects = read_json(Objects, path) if path else None
    image = files.images.get(name)
    failures = _Failures()
    failures.add("extraction", objects.objects if objects else [])
    made = []
    patterns = (f"matching/*/{name}/cousins.json", f"generation/*/{name}/scene_*.json")
    variants = {variant for pattern in patterns for variant in files.names(pattern, 1)}
    for variant in sorted(variants, key=natural):
        found_path = files.one(f"matching/{variant}/{name}/cousins.json")
        found = read_json(Cousins, found_path) if found_path else None
        failures.add(f"matching ({variant})", found.objects if found else [])
        scenes: list[RebuiltScene] = []
        first: GeneratedScene | None = None
        for place in files.all(f"generation/{variant}/{name}/scene_*.json"):
            scene = read_json(GeneratedScene, place)
            if first is None:
                first = scene
                failures.add(f"generation ({variant})", scene.objects)
            alt = f"Reconstruction of {label} from cousins of rank {scene.rank}"
            drawn = files.one(f"generation/{variant}/{name}/{place.stem}.png")
            scenes.append(_scene(scene, album.maybe(drawn, alt)))
        evidence = _evidence(files, name, objects, image, first) if objects else None
        pictured = matches(found, evidence, image, album, snapshots) if found else []
        view = _packed(files.one(f"generation/{variant}/{name}/view.glb"))
        encoder, decided = (found.encoder, _judge(found)) if found else ("", "")
        made.append(Reconstruction(variant, encoder, decided, scenes, pictured, view, _mend(image, name, variant)))
    return RoomPart(
        name=name,
        title=label.capitalize(),
        input=album.maybe(image, f"Input picture of {label}"),
        overview=album.maybe(files.one(f"extraction/{name}/overview.png"), f"What extraction found in {label}"),
        objects=len(objects.objects) if objects else 0,
        failures=failures.told,
        reconstructions=made,
    )


def collect(files: RunFiles, album: Album) -> list[RoomPart]:
    """Every room of the run, in order."""
    snapshots = Snapshots(files.all("assets/snapshots/shard_*.h5"))
    patterns = ("extraction/*/objects.json", "generation/*/*/scene_*.json")
    names = {*files.images, *(name for pattern in patterns for name in files.names(pattern, 0))}
    return [_room(files, name, album, snapshots) for name in sorted(names, key=natural)]
