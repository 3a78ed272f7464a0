"""What the page says of each room: input, reconstructions, cousins, failures, plausibility."""

from dataclasses import dataclass
from pathlib import Path

from stages.contracts.cousins import Cousin, Cousins, ObjectCousins
from stages.contracts.files import read_json
from stages.contracts.generated import GeneratedScene
from stages.contracts.objects import Objects, SceneObject
from stages.tables.order import natural, title
from stages.tables.page.pictures import Album, Picture

MOUNTING = {1: "on the wall", 2: "stands free", 3: "stands, touches a wall"}


@dataclass(frozen=True)
class Match:
    """One object of the image and the cousins found for it; `bar` scales distances to the worst one shown."""

    id: str
    about: str
    decided_by: str
    cousins: list[Cousin]
    bar: float


@dataclass(frozen=True)
class Generated:
    """The scene of one cousin rank."""

    rank: int
    placed: int
    moved: list[str]
    physics: str
    steady: bool | None


@dataclass(frozen=True)
class Reconstruction:
    """A room under one variant."""

    variant: str
    encoder: str
    comparison: Picture | None
    previews: list[Picture]
    scenes: list[Generated]
    matches: list[Match]
    cousins: Picture | None


@dataclass(frozen=True)
class Room:
    """A room and everything made of it; `failures` are (object, stage, reason)."""

    name: str
    title: str
    input: Picture | None
    overview: Picture | None
    objects: int
    failures: list[tuple[str, str, str]]
    reconstructions: list[Reconstruction]


def _about(seen: SceneObject | None) -> str:
    """'on the wall, 2 doors, 0.60 × 0.40 × 0.90 m'."""
    if seen is None:
        return ""
    parts = [MOUNTING[seen.mounting.type]] if seen.mounting else []
    for count, noun in ((seen.doors, "door"), (seen.drawers, "drawer")):
        parts += [f"{count} {noun}{'s' if count > 1 else ''}"] if count else []
    if seen.box:
        parts.append(" × ".join(f"{length:.2f}" for length in seen.box.size) + " m")
    return ", ".join(parts)


def _match(found: ObjectCousins, seen: SceneObject | None) -> Match:
    deciders = dict.fromkeys(name for name in (found.decided_by, found.orientation_decided_by) if name)
    worst = max((cousin.distance for cousin in found.cousins), default=0.0)
    return Match(found.id, _about(seen), " / ".join(deciders), found.cousins, worst or 1.0)


def _generated(scene: GeneratedScene) -> Generated:
    check = scene.plausibility
    physics = "not checked"
    if check:
        fallen = f", fallen: {', '.join(check.fallen)}" if check.fallen else ""
        physics = (
            f"{'stable' if check.stable else 'not stable'} after {check.seconds:g} s{fallen}; "
            f"moved {100 * check.mean_displacement:.1f} cm on average, {check.collisions} collisions, "
            f"deepest penetration {1000 * check.max_penetration:.1f} mm"
        )
    placed = [item for item in scene.objects if item.status == "ok"]
    moved = [f"{item.id} {100 * item.moved:.0f} cm" for item in placed if item.moved > 0.005]
    return Generated(scene.rank, len(placed), moved, physics, check.stable if check else None)


def _scenes(folder: Path) -> list[tuple[Path, GeneratedScene]]:
    paths = sorted(folder.glob("scene_*.json"), key=lambda path: natural(path.name))
    return [(path, read_json(GeneratedScene, path)) for path in paths]


def _variants(results: Path, room: str) -> list[str]:
    found = [*results.glob(f"matching/*/{room}/cousins.json"), *results.glob(f"generation/*/{room}/scene_*.json")]
    return sorted({path.parents[1].name for path in found}, key=natural)


def _room(results: Path, name: str, album: Album) -> Room:
    extraction = results / "extraction" / name
    seen = read_json(Objects, extraction / "objects.json").objects if (extraction / "objects.json").is_file() else []
    by_id = {item.id: item for item in seen}
    failures = [(item.id, "extraction", item.reason) for item in seen if item.status == "failed"]
    seen_failed = {item for item, _, _ in failures}
    made = []
    for variant in _variants(results, name):
        matching, generation = results / "matching" / variant / name, results / "generation" / variant / name
        found = read_json(Cousins, matching / "cousins.json") if (matching / "cousins.json").is_file() else None
        scenes = _scenes(generation)
        nearest = scenes[0][1].objects if scenes else []
        gone = set(seen_failed)
        for stage, items in (("matching", found.objects if found else []), ("generation", nearest)):
            failed = [item for item in items if item.status == "failed" and item.id not in gone]
            failures += [(item.id, f"{stage} ({variant})", item.reason) for item in failed]
            gone |= {item.id for item in failed}
        matched = [item for item in found.objects if item.status == "ok"] if found else []
        pictures = [
            album.maybe(path.with_suffix(".png"), f"Reconstruction of {title(name)} from cousins of rank {scene.rank}")
            for path, scene in scenes
        ]
        made.append(
            Reconstruction(
                variant=variant,
                encoder=found.encoder if found else "",
                comparison=album.maybe(
                    generation / "comparison.png", f"{title(name)}: the input picture beside its reconstruction"
                ),
                previews=[picture for picture in pictures if picture],
                scenes=[_generated(scene) for _, scene in scenes],
                matches=[_match(item, by_id.get(item.id)) for item in matched],
                cousins=album.maybe(matching / "cousins.png", f"Objects of {title(name)}, each beside its cousins"),
            )
        )
    return Room(
        name=name,
        title=title(name).capitalize(),
        input=album.maybe(results / "scenes" / name / "input" / "rgb.png", f"Input picture of {title(name)}"),
        overview=album.maybe(extraction / "overview.png", f"What extraction found in {title(name)}"),
        objects=len(seen),
        failures=failures,
        reconstructions=made,
    )


def collect(results: Path, album: Album) -> list[Room]:
    """Every room of which anything was made, in order."""
    patterns = ("scenes/*/input", "extraction/*/objects.json", "generation/*/*/scene_*.json")
    names = {path.parent.name for pattern in patterns for path in results.glob(pattern)}
    return [_room(results, name, album) for name in sorted(names, key=natural)]
