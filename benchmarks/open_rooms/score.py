"""What came out against the truth: a row per object and rank, and the tables of docs/results/open.md."""

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.open_rooms import packs, pictures
from benchmarks.open_rooms.by_clicks import find_things, list_steps
from benchmarks.open_rooms.shapes import ROOT, find_model, measure_chamfer
from roomkin.plugins.report.doubts import collect_doubts
from roomkin.plugins.scorecard import measures
from roomkin.plugins.scorecard.truth import PictureTruth, TrueThing
from roomkin.stages.contracts import Cousins, GeneratedScene, Objects, read_json
from roomkin.stages.contracts.categories import find_usual_size
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.generated import PlacedObject, measure_place_sureness, measure_sureness
from roomkin.stages.contracts.library import Asset
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.evaluation.scoring import box_in_world, world_from_floor
from roomkin.stages.generation.settling import OVERLAP
from roomkin.stages.geometry.boxes import UprightBox, axis_aligned_iou, oriented_iou

JUDGES = ("geometry", "hog", "no-image")
FLOATS, TOO_LARGE = 0.03, 2.0  # metres, times the largest of its category


@dataclass(frozen=True)
class Row:
    """One object of one reconstructed scene. What was not asked for or cannot be known is None."""

    half: str
    masks: str
    judge: str
    picture: str
    rank: int
    number: int
    label: str
    kind: str
    model: str
    seen: float
    cut: bool
    status: str  # ok, failed, missed
    asset: str = ""
    category: str = ""
    sensible: bool = False
    size: bool = False
    place: bool = False
    yaw: bool | None = None
    carrier: bool | None = None
    stable: bool = False
    off_depth_cm: float | None = None
    off_width_cm: float | None = None
    off_height_cm: float | None = None
    off_place_cm: float | None = None
    yaw_degrees: float | None = None
    chamfer: float | None = None
    panels: bool | None = None
    hinges: bool | None = None
    handles: bool | None = None
    support: str = ""
    held: bool = False
    floats: bool = False
    behind: bool = False
    too_large: bool = False
    collides: bool = False  # of the scene: two things in each other, or one in floor or wall
    doubt_of_size: bool = False
    sure_of_size: float | None = None
    sure_of_place: float | None = None
    iou: float | None = None
    oriented_iou: float | None = None


def hinges_alike(opens: tuple[str, ...], asset: Asset) -> bool | None:
    """Whether as many doors hang on each side and as many drawers slide; None: nothing opens, or how is not known."""
    if not measures.knows_hinges(opens):
        return None
    return sorted(opens) == sorted(joint.panel.hinge for joint in asset.joints if joint.panel is not None)


def handles_alike(handle: str, asset: Asset) -> bool | None:
    """Whether most of its handles are of this kind, arches as bars; None: none of these is stated."""
    if not handle:
        return None
    kinds = Counter("bar" if joint.handle == "arch" else joint.handle for joint in asset.joints)
    return bool(kinds) and kinds.most_common(1)[0][0] == handle


def find_true_carrier(true: TrueThing, ids: dict[int, str]) -> str | None:
    """What carries a thing, as a scene says it; None: that has no name in these masks; empty: it was not found."""
    return true.support if true.support in ("floor", "wall") else ids.get(int(true.support))


def count_missing(thing: TrueThing, opens: tuple[str, ...], handle: str, carrier: str | None) -> dict[str, bool]:
    """What is wrong about a thing that no scene has, of what is not asked of every thing."""
    asked = {
        "yaw": thing.symmetry != "full",
        "carrier": carrier is not None,
        "panels": thing.doors + thing.drawers > 0,
        "hinges": measures.knows_hinges(opens),
        "handles": bool(handle),
    }
    return {name: False for name in asked if asked[name]}


def score_scene(root: Path, folder: Path, masks: str, judge: str, folders: AssetFolders) -> Iterator[Row]:
    """The rows of one picture."""
    truth = pictures.read(folder)
    out = root / "results" / masks / folder.name
    joined = {int(inner) for inner in truth.joined} if masks == "drawn" else set()
    asked = [thing for thing in truth.things if thing.named and thing.number not in joined]
    scenes = sorted((out / judge).glob("scene_*.json"))
    base = {"half": truth.half, "masks": masks, "judge": judge, "picture": truth.name}

    def make_row(thing: TrueThing, rank: int, status: str, said: dict[str, Any]) -> Row:
        return Row(**base, rank=rank, number=thing.number, label=thing.label, kind=thing.kind, model=thing.model,
                   seen=thing.seen, cut=thing.cut, status=status, **said)  # fmt: skip

    def make_missing(thing: TrueThing, rank: int, status: str, ids: dict[int, str]) -> Row:
        model = find_model(thing.model, truth.half)
        said = count_missing(thing, model.opens, model.handle, find_true_carrier(thing, ids))
        return make_row(thing, rank, status, said)

    if not scenes:
        unknown = dict.fromkeys((thing.number for thing in asked), "")
        yield from (make_missing(thing, 1, "failed", unknown) for thing in asked)
        return
    objects = read_json(Objects, out / "extraction/objects.json")
    cousins = {entry.id: entry for entry in read_json(Cousins, out / judge / "cousins.json").objects}
    by_mask = {item.mask: item.id for item in objects.objects}
    ids = (
        by_mask
        if masks in pictures.BY_HAND
        else {number: by_mask.get(value, "") for number, value in find_things(root, folder, masks).items()}
    )
    for path in scenes:
        scene = read_json(GeneratedScene, path)
        placed = {item.id: item for item in scene.objects}
        scale = find_scale(truth, scene, ids) if masks == pictures.ALONE else 1.0
        for thing in asked:
            item = placed.get(ids.get(thing.number, ""))
            if item is None or item.status != "ok":
                yield make_missing(thing, scene.rank, "missed" if item is None else item.status, ids)
                continue
            seen = next(one for one in objects.objects if one.id == item.id)
            doubts = collect_doubts(cousins[item.id], seen, item, objects)
            said = _measure_thing(truth, thing, item, scene, objects, ids, folders, doubts, scale)
            yield make_row(thing, scene.rank, item.status, said)


def find_scale(truth: PictureTruth, scene: GeneratedScene, ids: dict[int, str]) -> float:
    """True over found distances from the camera, the median of what is placed: a picture alone tells no scale."""
    placed = {item.id: item for item in scene.objects if item.status == "ok"}
    world, eye = world_from_floor(truth.pose, scene.floor_from_camera), truth.pose[:3, 3]
    ratios = [
        np.linalg.norm(np.array(thing.position) - eye)
        / np.linalg.norm(np.asarray(box_in_world(item, world).center) - eye)
        for thing in truth.things
        if (item := placed.get(ids.get(thing.number, ""))) is not None
    ]
    return float(np.median(ratios)) if ratios else 1.0


def _measure_thing(
    truth: PictureTruth,
    thing: TrueThing,
    item: PlacedObject,
    scene: GeneratedScene,
    objects: Objects,
    ids: dict[int, str],
    folders: AssetFolders,
    doubts: list[Doubt],
    scale: float,
) -> dict[str, object]:
    box = box_in_world(item, world_from_floor(truth.pose, scene.floor_from_camera))
    eye = truth.pose[:3, 3]
    box = UprightBox(eye + scale * (np.asarray(box.center) - eye), scale * np.asarray(box.size), box.yaw)
    truth_box = UprightBox(thing.position, thing.size, thing.yaw)
    errors = measures.size_errors(thing, tuple(scale * np.array(item.size)), box.yaw)
    off = float(np.linalg.norm(np.array(box.center) - np.array(thing.position)))
    turn = measures.measure_turn(thing, box.yaw)
    carrier = find_true_carrier(thing, ids)
    asset = folders.asset(item.asset)
    model = find_model(thing.model, truth.half)
    check = scene.plausibility
    beneath = {one.id: one.position[2] + one.size[2] / 2 for one in scene.objects if one.status == "ok"}
    level = 0.0 if item.support == "floor" else beneath.get(item.support)
    bottom = item.position[2] - item.size[2] / 2
    known = find_usual_size(item.category)
    plan = np.log([*sorted(item.size[:2]), item.size[2]])
    return {
        "asset": item.asset,
        "category": item.category,
        "sensible": item.category in packs.kinds()[thing.kind].sensible,
        "size": measures.is_size_right(errors, thing.size),
        "place": off <= measures.PLACE,
        "yaw": None if turn is None else turn <= measures.YAW,
        "carrier": None if carrier is None else item.support == carrier,
        "stable": item.support != "unnamed" and check is not None and item.id not in check.fallen,
        "off_depth_cm": round(100 * float(errors[0]), 1),
        "off_width_cm": round(100 * float(errors[1]), 1),
        "off_height_cm": round(100 * float(errors[2]), 1),
        "off_place_cm": round(100 * off, 1),
        "yaw_degrees": None if turn is None else round(float(np.rad2deg(turn)), 1),
        "chamfer": round(measure_chamfer(thing.model, truth.half, folders[item.asset], tuple(thing.size)), 4),
        "panels": (asset.doors, asset.drawers) == (thing.doors, thing.drawers) if thing.doors + thing.drawers else None,
        "hinges": hinges_alike(model.opens, asset),
        "handles": handles_alike(model.handle, asset),
        "support": item.support,
        "held": item.support == "unnamed",
        "floats": level is not None and bottom > level + FLOATS,
        "behind": measures.measure_overreach(box, truth.size) > measures.MAX_BEHIND,
        "too_large": known is not None and bool((plan > known.high + np.log(TOO_LARGE)).any()),
        "collides": check is not None and (check.collisions > 0 or check.max_penetration > OVERLAP),
        "doubt_of_size": any(doubt.cause == "size" for doubt in doubts),
        "sure_of_size": None if item.size_spread is None else round(measure_sureness(item.size, item.size_spread), 3),
        "sure_of_place": None if item.place_spread is None else round(measure_place_sureness(item.place_spread), 3),
        "iou": round(axis_aligned_iou(box, truth_box), 3),
        "oriented_iou": round(oriented_iou(box, truth_box), 3),
    }


def score(root: Path, results: Path, out: Path, version: str) -> None:
    """Write open.csv.xz (a row per object and rank), clicks.csv, open_sizes.svg, open.md; `version`: of the code."""
    from benchmarks.open_rooms.sureness import draw_sureness
    from benchmarks.open_rooms.tables import page

    ROOT[:] = [root]
    folders = AssetFolders(results / "assets/library/library.json")
    rows, steps = list[Row](), list[dict[str, Any]]()
    for masks in pictures.MASKS:
        made = root / "results" / masks
        for half in packs.HALVES:
            tried = [one for one in pictures.folders(root, half) if (made / one.name).is_dir()]
            judges = {log.stem for folder in tried for log in (made / folder.name).glob("*.log")} & set(JUDGES)
            for folder, judge in itertools.product(tried, sorted(judges)):
                rows += score_scene(root, folder, masks, judge, folders)
            if masks == "unaided":
                steps += [row for folder in tried for row in list_steps(root, folder)]
    table = pd.DataFrame(rows).assign(version=version)
    out.mkdir(parents=True, exist_ok=True)
    table.to_csv(out / "open.csv.xz", index=False)
    if steps:
        pd.DataFrame(steps).to_csv(out / "clicks.csv", index=False)
    main = table[(table["rank"] == 1) & (table["judge"] == "geometry")]
    draw_sureness(main[main["masks"] == "drawn"], out / "open_sizes.svg")
    (out / "open.md").write_text(page(table, pd.DataFrame(steps)), encoding="utf-8")
    print(f"{out / 'open.md'}: {len(table)} rows")
