"""Results of all stages for one picture under one variant of matching."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from roomkin.plugins.report.doubts import collect_doubts
from roomkin.stages.contracts.cousins import Cousins, ObjectCousins
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject
from roomkin.stages.contracts.objects import Objects, SceneObject
from roomkin.stages.extraction.camera_height import doubt_height


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
