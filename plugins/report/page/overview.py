"""A row of the overview for every scene: its result, what failed and why, what is in doubt."""

import base64
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from plugins.report.doubts import Group, group_doubts
from plugins.report.page.findings import Findings
from stages.tables.order import sort_key
from stages.tables.text import NOT_RUN

NUMBER = re.compile(r"\d+(\.\d+)?")


@dataclass(frozen=True)
class Failure:
    """An object that failed, or (`about` empty) a scene that stopped, in a stage, for a reason."""

    about: str
    stage: str
    reason: str


@dataclass(frozen=True)
class SceneRow:
    """A scene.

    page: link to its own; empty: none. picture: of input and rank 1, a data URI. stands: of `ranks` scenes; None: not
    checked.
    """

    name: str
    page: str
    picture: str
    objects: int
    placed: int
    ranks: int
    stands: int | None
    failures: list[Failure]
    doubts: list[Group]

    @property
    def doubted(self) -> int:
        """How many things are in doubt."""
        return len({about for group in self.doubts for about, _ in group.items})

    @property
    def stopped(self) -> Failure | None:
        """Where and why the scene stopped."""
        return next((failure for failure in self.failures if not failure.about), None)


@dataclass(frozen=True)
class Layout:
    """Where the run's files lie: `results` and `logs`, of one variant."""

    results: Path
    logs: Path
    variant: str

    def steps(self, scene: str) -> Iterator[tuple[str, Path, list[Path]]]:
        """Stage, what it makes, and its logs, the last job's first, in the order of the stages."""
        before = (f"extraction/{scene}", f"scenes/frame_{scene}", f"photo/{scene}", f"scenes/{scene}")
        folder = self.results / "generation" / self.variant / scene
        yield "extraction", self.results / f"extraction/{scene}/objects.json", [*map(self._log, before)]
        yield (
            "matching",
            self.results / f"matching/{self.variant}/{scene}/cousins.json",
            [self._log(f"matching/{self.variant}_{scene}")],
        )
        yield "generation", folder / "scene_1.json", [self._log(f"generation/{self.variant}_{scene}")]
        yield "drawing", folder / "thumbnail.webp", [self._log(f"generation/draw_{self.variant}_{scene}")]

    def _log(self, name: str) -> Path:
        return self.logs / f"{name}.log"


def row(scene: str, layout: Layout, page: str = "") -> SceneRow:
    """The row of a scene; `page`: link to its own.

    Where a stage has stopped, files of later stages are of an earlier run and do not count.
    """
    done: dict[str, Path] = {}
    failures: list[Failure] = []
    for stage, path, logs in layout.steps(scene):
        if not path.is_file():
            failures.append(Failure("", stage, _last_line(logs)))
            break
        done[stage] = path
    scenes = done["generation"].parent.glob("scene_*.json") if "generation" in done else []
    in_order = sorted(scenes, key=lambda path: sort_key(path.name))
    found = Findings.read(done.get("extraction"), done.get("matching"), in_order)
    failures += [Failure(about, stage, reason) for about, (stage, reason) in found.failures().items()]
    checks = [scene.plausibility for scene in found.scenes if scene.plausibility]
    return SceneRow(
        name=scene,
        page=page,
        picture=_embed_picture(done.get("drawing")),
        objects=len(found.seen),
        placed=sum(item.status == "ok" for item in found.placed.values()),
        ranks=len(found.scenes),
        stands=sum(not check.wrong for check in checks) if checks else None,
        failures=failures,
        doubts=group_doubts(found.doubts()),
    )


def _last_line(logs: list[Path]) -> str:
    """The last line of the first log that is there."""
    log = next((path for path in logs if path.is_file()), None)
    if log is None:
        return NOT_RUN
    lines = log.read_text(encoding="utf-8", errors="replace").split("\n")
    last = next((line.strip() for line in reversed(lines) if line.strip()), f"{log} is empty: the job was killed")
    return last.removeprefix("error: ")


def _embed_picture(picture: Path | None) -> str:
    return f"data:image/webp;base64,{base64.b64encode(picture.read_bytes()).decode('ascii')}" if picture else ""


def count_failures(rows: Iterable[SceneRow]) -> list[tuple[str, int]]:
    """The most frequent failures with their counts; reasons that differ by numbers only are one."""
    failures = (failure for one in rows for failure in one.failures if failure.reason != NOT_RUN)
    return Counter(f"{each.stage}: {NUMBER.sub('…', each.reason)}" for each in failures).most_common(8)
