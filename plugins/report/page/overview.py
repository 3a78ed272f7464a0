"""A picture's results of all stages, and its row of the overview: what failed and why, what is in doubt."""

import base64
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from roomkin.plugins.report.doubts import Group, collect_doubts, group_doubts
from roomkin.stages.contracts.cousins import Cousins, ObjectCousins
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject, Plausibility
from roomkin.stages.contracts.objects import Objects, SceneObject
from roomkin.stages.extraction.floor import doubt_height
from roomkin.stages.tables.rows import sort_key
from roomkin.stages.tables.text import NOT_RUN


@dataclass(frozen=True)
class Findings:
    """The files of the stages, as far as they are there; scenes by rank."""

    objects: Objects | None = None
    cousins: Cousins | None = None
    scenes: list[GeneratedScene] = field(default_factory=list)

    @classmethod
    def read(cls, objects: Path | None, cousins: Path | None, scenes: Iterable[Path]) -> "Findings":
        """Read the files that exist."""
        found = read_json(Objects, objects) if objects else None, read_json(Cousins, cousins) if cousins else None
        return cls(*found, [read_json(GeneratedScene, path) for path in scenes])

    @property
    def seen(self) -> dict[str, SceneObject]:
        """Objects of the picture, by id."""
        return {item.id: item for item in self.objects.objects} if self.objects else {}

    @property
    def placed(self) -> dict[str, PlacedObject]:
        """Objects of the scene of rank 1, by id."""
        return {item.id: item for item in self.scenes[0].objects} if self.scenes else {}

    def doubts_of(self, scene: GeneratedScene | None) -> list[tuple[str, Doubt]]:
        """The doubts about a scene (None: there is none), each with its object."""
        placed = {item.id: item for item in scene.objects} if scene else {}
        return [
            (entry.id, doubt)
            for entry, item in self.matched
            for doubt in collect_doubts(entry, item, placed.get(entry.id), self.objects)  # type: ignore[arg-type]
        ]

    def list_further_doubts(self, scene: GeneratedScene) -> list[tuple[str, Doubt]]:
        """Doubts about a scene that the first scene does not have."""
        first = set(self.doubts_of(self.scenes[0]))
        return [one for one in self.doubts_of(scene) if one not in first]

    def count_new_models(self, scene: GeneratedScene) -> int:
        """How many objects of a scene have a model that no earlier scene has for them."""
        used = {(item.id, item.asset) for other in self.scenes if other.rank < scene.rank for item in other.objects}
        return sum(item.status == "ok" and (item.id, item.asset) not in used for item in scene.objects)

    @property
    def distinct(self) -> dict[str, int]:
        """The number of different models for each object over all scenes, by its id."""
        placed = {(item.id, item.asset) for scene in self.scenes for item in scene.objects if item.status == "ok"}
        return dict(Counter(name for name, _ in sorted(placed)))

    @property
    def matched(self) -> list[tuple[ObjectCousins, SceneObject]]:
        """Objects that have cousins."""
        seen, matched = self.seen, self.cousins.objects if self.cousins else []
        return [(entry, seen[entry.id]) for entry in matched if entry.status == "ok" and entry.id in seen]

    def failures(self) -> dict[str, tuple[str, str]]:
        """Object -> the stage where it failed first, and why."""
        found: dict[str, tuple[str, str]] = {}
        matched = self.cousins.objects if self.cousins else []
        parts: dict[str, Iterable[SceneObject | ObjectCousins | PlacedObject]]
        parts = {"extraction": self.seen.values(), "matching": matched, "generation": self.placed.values()}
        for stage, items in parts.items():
            for item in items:
                if item.status == "failed":
                    found.setdefault(item.id, (stage, item.reason or "no reason given"))
        return found

    @property
    def camera_doubt(self) -> Doubt | None:
        """A warning about the camera's height; None: it is usual."""
        what = doubt_height(self.objects.floor_from_camera[2][3]) if self.objects else ""
        return DoubtKind.CAMERA_HEIGHT.of(what=what) if what else None

    def doubts(self) -> list[tuple[str, Doubt]]:
        """Object, or the camera, and what may be wrong with it."""
        camera = [("camera", self.camera_doubt)] if self.camera_doubt else []
        return camera + self.doubts_of(self.scenes[0] if self.scenes else None)


NUMBER = re.compile(r"\d+(\.\d+)?")


class FailedObject(NamedTuple):
    """An object that failed, or (`about` empty) a scene that stopped, in a stage, for a reason."""

    about: str
    stage: str
    reason: str


class SceneRow(NamedTuple):
    """A scene. page: link to its own; empty: none. picture: of input and rank 1, a data URI; empty: none."""

    name: str
    page: str
    picture: str
    found: Findings
    failures: list[FailedObject]
    doubts: list[Group]

    @property
    def placed(self) -> int:
        """How many objects stand in the scene of rank 1."""
        return sum(item.status == "ok" for item in self.found.placed.values())

    @property
    def checks(self) -> list[Plausibility]:
        """The verdict of physics on the scenes where it ran."""
        return [scene.plausibility for scene in self.found.scenes if scene.plausibility]

    @property
    def doubted(self) -> int:
        """How many things are in doubt."""
        return len({about for group in self.doubts for about, _ in group.items})

    @property
    def stopped(self) -> FailedObject | None:
        """Where and why the scene stopped."""
        return next((failure for failure in self.failures if not failure.about), None)


class RunFolders(NamedTuple):
    """The folders of the run's files: `results` and `logs`, of one variant."""

    results: Path
    logs: Path
    variant: str

    def steps(self, scene: str) -> Iterator[tuple[str, Path, list[Path]]]:
        """Stage, what it makes, and its logs, the last job's first, in the order of the stages."""
        variant, extraction = self.variant, ("extraction/{}", "scenes/frame_{}", "photo/{}", "scenes/{}")
        for stage, made, logs in (
            ("extraction", f"extraction/{scene}/objects.json", [name.format(scene) for name in extraction]),
            ("matching", f"matching/{variant}/{scene}/cousins.json", [f"matching/{variant}_{scene}"]),
            ("generation", f"generation/{variant}/{scene}/scene_1.json", [f"generation/{variant}_{scene}"]),
            ("drawing", f"generation/{variant}/{scene}/thumbnail.webp", [f"generation/draw_{variant}_{scene}"]),
        ):
            yield stage, self.results / made, [self.logs / f"{name}.log" for name in logs]


def row(scene: str, layout: RunFolders, page: str = "") -> SceneRow:
    """The row of a scene; `page`: link to its own.

    Where a stage has stopped, files of later stages are of an earlier run and do not count.
    """
    done: dict[str, Path] = {}
    failures: list[FailedObject] = []
    for stage, path, logs in layout.steps(scene):
        if not path.is_file():
            failures.append(FailedObject("", stage, _last_line(logs)))
            break
        done[stage] = path
    scenes = done["generation"].parent.glob("scene_*.json") if "generation" in done else []
    in_order = sorted(scenes, key=lambda path: sort_key(path.name))
    found = Findings.read(done.get("extraction"), done.get("matching"), in_order)
    failures += [FailedObject(about, stage, reason) for about, (stage, reason) in found.failures().items()]
    data = base64.b64encode(done["drawing"].read_bytes()).decode("ascii") if "drawing" in done else ""
    picture = data and f"data:image/webp;base64,{data}"
    return SceneRow(scene, page, picture, found, failures, group_doubts(found.doubts()))


def _last_line(logs: list[Path]) -> str:
    """The last line of the first log that is there."""
    log = next((path for path in logs if path.is_file()), None)
    if log is None:
        return NOT_RUN
    lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1].strip().removeprefix("error: ") if lines else f"{log} is empty: the job was killed"


def count_failures(rows: Iterable[SceneRow]) -> list[tuple[str, int]]:
    """The most frequent failures with their counts; reasons that differ by numbers only are one."""
    failures = (failure for one in rows for failure in one.failures if failure.reason != NOT_RUN)
    return Counter(f"{each.stage}: {NUMBER.sub('…', each.reason)}" for each in failures).most_common(8)
