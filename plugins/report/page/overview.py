"""A row of the overview for every scene: its result, what failed and why, what is in doubt."""

import base64
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from roomkin.plugins.report.doubts import Group, group_doubts
from roomkin.plugins.report.page.findings import Findings
from roomkin.stages.contracts.generated import Plausibility
from roomkin.stages.tables.order import sort_key
from roomkin.stages.tables.text import NOT_RUN

NUMBER = re.compile(r"\d+(\.\d+)?")


class Failure(NamedTuple):
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
    failures: list[Failure]
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
    def stopped(self) -> Failure | None:
        """Where and why the scene stopped."""
        return next((failure for failure in self.failures if not failure.about), None)


class Layout(NamedTuple):
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
    picture = base64.b64encode(done["drawing"].read_bytes()).decode("ascii") if "drawing" in done else ""
    return SceneRow(
        scene, page, picture and f"data:image/webp;base64,{picture}", found, failures, group_doubts(found.doubts())
    )


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
