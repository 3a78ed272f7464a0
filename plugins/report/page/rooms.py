"""The page's sections about rooms: input, reconstructions, failures, plausibility, and what its files were made of."""

import base64
import gzip
import shlex
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from plugins.report.album import Album, Picture
from plugins.report.page.files import RunFiles
from plugins.report.page.findings import Findings
from plugins.report.page.objects import Evidence, Match, match
from plugins.report.snapshots import Snapshots, views_of
from stages.contracts.cousins import Cousins
from stages.contracts.doubt import Doubt
from stages.contracts.extracted import read_clouds, read_object_masks
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene
from stages.contracts.images import read_rgb
from stages.contracts.objects import Objects
from stages.contracts.provenance import Provenance
from stages.plugins import shorten_name
from stages.tables.order import sort_key, title
from stages.tables.table2 import judge


@dataclass(frozen=True)
class RebuiltScene:
    """The scene of one cousin rank; `stands` is None if physics was not checked; `wrong`: why it does not.
    `doubts`: beyond those of rank 1;
    `new`: objects with a model that no earlier rank has there."""

    rank: int
    picture: Picture | None
    placed: int
    moved: list[str]
    physics: str
    stands: bool | None
    wrong: str
    doubts: list[tuple[str, Doubt]]
    new: int


@dataclass(frozen=True)
class Reconstruction:
    """A room under one variant.

    judge: who decided on models and orientations. view: the scene of the first rank to turn, binary glTF, gzip in
    base64; empty: none. correct: the command, up to an object's id, that opens the page to correct it; empty: none.
    furnished: the room was furnished from the library, so that models of rank 1 may be those of the picture;
    distinct: how many different models stand for an object over the scenes, by its id.
    """

    variant: str
    encoder: str
    judge: str
    scenes: list[RebuiltScene]
    matches: list[Match]
    view: str
    correct: str
    furnished: bool
    distinct: dict[str, int]

    @property
    def fewer(self) -> dict[int, list[str]]:
        """Objects with fewer different models than there are scenes, by that number."""
        found: dict[int, list[str]] = {}
        for name, models in sorted(self.distinct.items(), key=lambda item: item[1]):
            if models < len(self.scenes):
                found.setdefault(models, []).append(name.replace("_", " "))
        return found

    @property
    def shown(self) -> int:
        """The rank that is shown first: one without twins, where there is one."""
        ranks = [scene.rank for scene in self.scenes if scene.picture]
        return ranks[1] if self.furnished and len(ranks) > 1 else ranks[0]

    @property
    def title(self) -> str:
        """Its name, with the encoder and the judge of this run."""
        named = {"encoder": self.encoder, "judge": self.judge}
        return " · ".join([f"Variant {self.variant}", *(f"{what} {name}" for what, name in named.items() if name)])


@dataclass(frozen=True)
class RoomPart:
    """A room and all that was made of it; `failures`: object -> (stage, reason); `origins`: file -> its provenance;
    `camera_doubt`: what is odd about the camera's height, None: nothing."""

    name: str
    title: str
    input: Picture | None
    overview: Picture | None
    objects: int
    failures: dict[str, tuple[str, str]]
    reconstructions: list[Reconstruction]
    origins: dict[str, Provenance]
    camera_doubt: Doubt | None


def _scene(scene: GeneratedScene, found: Findings, picture: Picture | None) -> RebuiltScene:
    check = scene.plausibility
    physics = "not checked"
    if check:
        physics = (
            f"after {check.seconds:g} s it {check.verdict}; "
            f"moved {100 * check.mean_displacement:.1f} cm on average, {check.collisions} collisions, "
            f"deepest penetration {1000 * check.max_penetration:.1f} mm"
        )
    placed = [item for item in scene.objects if item.status == "ok"]
    moved = [f"{item.id} {100 * item.moved:.0f} cm" for item in placed if round(item.moved, 2)]
    return RebuiltScene(
        rank=scene.rank,
        picture=picture,
        placed=len(placed),
        moved=moved,
        physics=physics,
        stands=not check.wrong if check else None,
        wrong=check.wrong if check else "",
        doubts=found.list_further_doubts(scene),
        new=found.count_new_models(scene),
    )


def _evidence(files: RunFiles, room: str, found: Findings, image: Path | None) -> Evidence:
    """What the run has of a room beside its objects."""
    path, objects = files.find_first(f"extraction/{room}/objects.json"), found.objects
    assert path is not None and objects is not None
    masks, clouds = (files.find_first(f"extraction/{room}/{name}") for name in ("masks.png", "clouds.npz"))
    rgb = read_rgb(image) if image else None
    return Evidence(
        objects,
        rgb if rgb is not None and rgb.shape[:2] == (objects.height, objects.width) else None,
        read_object_masks(path, objects) if masks else None,
        read_clouds(path, objects) if clouds else {},
        found.placed,
        {item.id: views_of(found.scenes, item.id) for item in objects.objects},
    )


def _judge(found: Cousins) -> str:
    """As in Table 2; objects that nobody decided on do not count."""
    deciders = [(item.decided_by, item.orientation_decided_by) for item in found.objects]
    return judge(pd.DataFrame(deciders, columns=["model_judge", "orientation_judge"]))


def _correct(image: Path | None, scene: str, variant: str) -> str:
    if image is None:
        return ""
    arguments = ["annotate", str(image.parent), "--scene", scene, "--variant", variant, "--choose"]
    return f"python -m plugins.studio {shlex.join(arguments)} "


def origins(files: RunFiles, name: str) -> dict[str, Provenance]:
    """Provenance of objects, cousins and the scenes of rank 1, as far as the files hold it, by file."""
    kinds: list[tuple[type[Objects | Cousins | GeneratedScene], str]] = [
        (Objects, f"extraction/{name}/objects.json"),
        (Cousins, f"matching/*/{name}/cousins.json"),
        (GeneratedScene, f"generation/*/{name}/scene_1.json"),
    ]
    found = {path: read_json(kind, path).made for kind, pattern in kinds for path in files.find_all(pattern)}
    return {"/".join(path.parts[-3:]): provenance for path, provenance in found.items() if provenance is not None}


def _findings(files: RunFiles, name: str, variant: str) -> Findings:
    return Findings.read(
        files.find_first(f"extraction/{name}/objects.json"),
        files.find_first(f"matching/{variant}/{name}/cousins.json"),
        files.find_all(f"generation/{variant}/{name}/scene_*.json"),
    )


def _reconstruction(
    files: RunFiles, name: str, variant: str, found: Findings, album: Album, snapshots: Snapshots
) -> Reconstruction:
    cousins, folder, image = found.cousins, f"generation/{variant}/{name}", files.images.get(name)
    matches = []
    if cousins and found.objects:
        evidence = _evidence(files, name, found, image)
        matches = [match(entry, item, evidence, album, snapshots) for entry, item in found.matched]
    alt, view = f"Reconstruction of {title(name)} from cousins of rank", files.find_first(f"{folder}/view.glb")
    return Reconstruction(
        variant=variant,
        encoder=shorten_name(cousins.encoder) if cousins else "",
        judge=_judge(cousins) if cousins else "",
        scenes=[
            _scene(
                scene, found, album.maybe(files.find_first(f"{folder}/scene_{scene.rank}.png"), f"{alt} {scene.rank}")
            )
            for scene in found.scenes
        ],
        matches=matches,
        view=base64.b64encode(gzip.compress(view.read_bytes(), 9, mtime=0)).decode("ascii") if view else "",
        correct=_correct(image, name, variant),
        furnished=image is not None and image.match(f"scenes/{name}/input/*"),
        distinct=found.distinct,
    )


def _room(files: RunFiles, name: str, album: Album, snapshots: Snapshots) -> RoomPart:
    label = title(name)
    patterns = (f"matching/*/{name}/cousins.json", f"generation/*/{name}/scene_*.json")
    variants = sorted({variant for pattern in patterns for variant in files.names(pattern, 1)}, key=sort_key)
    found = {variant: _findings(files, name, variant) for variant in variants or [""]}
    failures: dict[str, tuple[str, str]] = {}
    for variant, each in found.items():
        for one, (stage, reason) in each.failures().items():
            failures.setdefault(one, (stage if stage == "extraction" else f"{stage} ({variant})", reason))
    return RoomPart(
        name=name,
        title=label.capitalize(),
        input=album.maybe(files.images.get(name), f"Input picture of {label}"),
        overview=album.maybe(files.find_first(f"extraction/{name}/overview.png"), f"What extraction found in {label}"),
        objects=len(next(iter(found.values())).seen),
        failures=failures,
        reconstructions=[
            _reconstruction(files, name, variant, found[variant], album, snapshots) for variant in variants
        ],
        origins=origins(files, name),
        camera_doubt=next(iter(found.values())).camera_doubt,
    )


def collect(files: RunFiles, album: Album) -> list[RoomPart]:
    """Every room of the run, in order."""
    snapshots = Snapshots(files.find_all("assets/snapshots/shard_*.h5"))
    patterns = ("extraction/*/objects.json", "generation/*/*/scene_*.json")
    names = {*files.images, *(name for pattern in patterns for name in files.names(pattern, 0))}
    return [_room(files, name, album, snapshots) for name in sorted(names, key=sort_key)]
