"""The page's sections about rooms: input, reconstructions, failures, plausibility, and what its files were made of."""

import base64
import gzip
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from roomkin.plugins.report.album import Album, PagePicture, SnapshotShards, views_of
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.objects import Match, RoomResults, match
from roomkin.plugins.report.page.overview import Findings
from roomkin.stages.contracts.cousins import Cousins
from roomkin.stages.contracts.doubt import Doubt, Provenance
from roomkin.stages.contracts.extracted import read_clouds, read_object_masks
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.objects import Objects
from roomkin.stages.plugins import shorten_name
from roomkin.stages.tables.rows import sort_key, title, variant_key
from roomkin.stages.tables.table2 import judge


class RebuiltScene(NamedTuple):
    """The scene of one cousin rank, its picture, doubts beyond those of rank 1, how many of its objects have a model
    that no earlier rank has there, and the scene to turn, binary glTF, gzip in base64; empty: none."""

    scene: GeneratedScene
    picture: PagePicture | None
    doubts: list[tuple[str, Doubt]]
    new: int
    view: str = ""


@dataclass(frozen=True)
class Reconstruction:
    """A room under one variant.

    correct: the command that opens the page to correct it; empty: none. furnished: the room was furnished from the
    library, so that models of rank 1 may be those of the picture.
    """

    variant: str
    found: Findings
    scenes: list[RebuiltScene]
    matches: list[Match]
    correct: str
    furnished: bool

    def choose(self, name: str) -> str:
        """The command that opens that page with an object chosen; empty: none."""
        return self.correct and f"{self.correct} --choose {name}"

    @property
    def fewer(self) -> dict[int, list[str]]:
        """Objects with fewer different models than there are scenes, by that number."""
        found: dict[int, list[str]] = {}
        for name, models in sorted(self.found.distinct.items(), key=lambda item: item[1]):
            if models < len(self.scenes):
                found.setdefault(models, []).append(name.replace("_", " "))
        return found

    @property
    def shown(self) -> int:
        """The rank that is shown first: one without twins, where there is one."""
        ranks = [one.scene.rank for one in self.scenes if one.picture]
        return ranks[1] if self.furnished and len(ranks) > 1 else ranks[0]

    @property
    def title(self) -> str:
        """Its name, with the encoder and the judge of this run."""
        cousins = self.found.cousins
        named = {"encoder": shorten_name(cousins.encoder), "judge": _judge(cousins)} if cousins else {}
        return " · ".join([f"Variant {self.variant}", *(f"{what} {name}" for what, name in named.items() if name)])


@dataclass(frozen=True)
class RoomPart:
    """A room and all that was made of it; `found`: under the first variant; `failures`: object -> (stage, reason);
    `origins`: file -> its provenance."""

    name: str
    title: str
    input: PagePicture | None
    overview: PagePicture | None
    found: Findings
    failures: dict[str, tuple[str, str]]
    reconstructions: list[Reconstruction]
    origins: dict[str, Provenance]


def _match_objects(
    files: RunFiles, room: str, found: Findings, image: Path | None, album: Album, snapshots: SnapshotShards
) -> list[Match]:
    """The objects that have cousins, with what else the run has of the room."""
    path, objects = files.find_first(f"extraction/{room}/objects.json"), found.objects
    if path is None or objects is None or found.cousins is None:
        return []
    masks, clouds = (files.find_first(f"extraction/{room}/{name}") for name in ("masks.png", "clouds.npz"))
    rgb = read_rgb(image) if image else None
    evidence = RoomResults(
        objects,
        rgb if rgb is not None and rgb.shape[:2] == (objects.height, objects.width) else None,
        read_object_masks(path, objects) if masks else None,
        read_clouds(path, objects) if clouds else {},
        found.placed,
        {item.id: views_of(found.scenes, item.id) for item in objects.objects},
    )
    return [match(entry, item, evidence, album, snapshots) for entry, item in found.matched]


def _judge(found: Cousins) -> str:
    """As in Table 2; objects that nobody decided on do not count."""
    deciders = [(item.decided_by, item.orientation_decided_by) for item in found.objects]
    return judge(pd.DataFrame(deciders, columns=["model_judge", "orientation_judge"]))


def _pack(view: Path | None) -> str:
    return base64.b64encode(gzip.compress(view.read_bytes(), 9, mtime=0)).decode("ascii") if view else ""


def _rebuild(
    files: RunFiles, name: str, variant: str, found: Findings, album: Album, snapshots: SnapshotShards
) -> Reconstruction:
    folder, image = f"generation/{variant}/{name}", files.images.get(name)
    alt = f"Reconstruction of {title(name)} from cousins of rank"
    ranks = [scene.rank for scene in found.scenes]
    pictures = [album.add(files.find_first(f"{folder}/scene_{rank}.png"), f"{alt} {rank}") for rank in ranks]
    correct = shlex.join(["annotate", str(image and image.parent), "--scene", name, "--variant", variant])
    return Reconstruction(
        variant=variant,
        found=found,
        scenes=[
            RebuiltScene(
                scene,
                picture,
                found.list_further_doubts(scene),
                found.count_new_models(scene),
                _pack(files.find_first(f"{folder}/view_{scene.rank}.glb")),
            )
            for scene, picture in zip(found.scenes, pictures, strict=True)
        ],
        matches=_match_objects(files, name, found, image, album, snapshots),
        correct=f"roomkin annotator {correct}" if image else "",
        furnished=image is not None and image.match(f"scenes/{name}/input/*"),
    )


def _list_origins(name: str, found: dict[str, Findings]) -> dict[str, Provenance]:
    """Provenance of objects, cousins and the scenes of rank 1, as far as the files hold it, by file."""
    documents: dict[str, Objects | Cousins | GeneratedScene | None] = {}
    documents |= {f"extraction/{name}/objects.json": each.objects for each in found.values()}
    documents |= {f"{variant}/{name}/cousins.json": each.cousins for variant, each in found.items()}
    documents |= {f"{variant}/{name}/scene_1.json": one for variant, each in found.items() for one in each.scenes[:1]}
    return {path: document.made for path, document in documents.items() if document and document.made}


def _room(files: RunFiles, name: str, album: Album, snapshots: SnapshotShards) -> RoomPart:
    label = title(name)
    patterns = (f"matching/*/{name}/cousins.json", f"generation/*/{name}/scene_*.json")
    variants = sorted({variant for pattern in patterns for variant in files.names(pattern, 1)}, key=variant_key)
    found = {
        variant: Findings.read(
            files.find_first(f"extraction/{name}/objects.json"),
            files.find_first(f"matching/{variant}/{name}/cousins.json"),
            files.find_all(f"generation/{variant}/{name}/scene_*.json"),
        )
        for variant in variants or [""]
    }
    failures: dict[str, tuple[str, str]] = {}
    for variant, each in found.items():
        for one, (stage, reason) in each.failures().items():
            failures.setdefault(one, (stage if stage == "extraction" else f"{stage} ({variant})", reason))
    return RoomPart(
        name=name,
        title=label.capitalize(),
        input=album.add(files.images.get(name), f"Input picture of {label}"),
        overview=album.add(files.find_first(f"extraction/{name}/overview.png"), f"What extraction found in {label}"),
        found=next(iter(found.values())),
        failures=failures,
        reconstructions=[_rebuild(files, name, variant, found[variant], album, snapshots) for variant in variants],
        origins=_list_origins(name, found),
    )


def collect(files: RunFiles, album: Album) -> list[RoomPart]:
    """Every room of the run, in order."""
    snapshots = SnapshotShards(files.find_all("assets/snapshots/shard_*.h5"))
    patterns = ("extraction/*/objects.json", "generation/*/*/scene_*.json")
    names = {*files.images, *(name for pattern in patterns for name in files.names(pattern, 0))}
    return [_room(files, name, album, snapshots) for name in sorted(names, key=sort_key)]
