"""A small made-up run in the fixed layout: two rooms, one task, every kind of file that the report reads."""

import csv
import json
from pathlib import Path

import h5py
import numpy as np
from PIL import Image, ImageDraw
from pydantic import BaseModel

from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.cousins import Cousin, Cousins, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import Provenance
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject, Plausibility
from roomkin.stages.contracts.library import Library, LibraryEntry, SnapshotShard
from roomkin.stages.contracts.objects import Box, Mounting, Objects, SceneObject
from roomkin.stages.contracts.policies import Attempt, Rollout, SceneScore, TaskAsset, TaskAssets
from tests.unit.demo_assets import FRONT

VIEWER = Path(__file__).parents[2] / "plugins/report/page/three/three.min.js"
CAMERA = [[200.0, 0.0, 120.0], [0.0, 200.0, 80.0], [0.0, 0.0, 1.0]]
POSE = [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.4], [0.0, 0.0, 0.0, 1.0]]
MADE = Provenance(seed=11, options="0a1b2c3d4e5f", inputs="111111111111", code="222222222222")
LABELS = {"room_1": ["cabinet", "bowl", "lamp"], "room_2": ["table", "chair"]}
ABOUT = FRONT | {"digest": "0", "handle_length": 0.12, "handle_height": 0.5}
ROLES = {"twin": 0.0, "cousin_1": 3.1, "cousin_2": 4.0, "cousin_6": 7.5, "dissimilar": 12.25}


def picture(path: Path, width: int = 240, height: int = 160, seed: int = 0) -> None:
    """A picture of colored boxes on a floor."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), (214, 209, 200))
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, height * 0.6, width, height), fill=(168, 150, 130))
    for _ in range(4):
        x, w, h = rng.integers(0, width - 40), rng.integers(20, width // 3), rng.integers(20, height // 2)
        color = tuple(int(c) for c in rng.integers(60, 200, 3))
        draw.rectangle((x, height * 0.75 - h, x + w, height * 0.75), fill=color, outline=(60, 60, 60))
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path)


def film(path: Path, frames: int = 6) -> None:
    """An animated WebP of a box that moves to the right."""
    pictures = []
    for frame in range(frames):
        image = Image.new("RGB", (80, 64), (200, 205, 210))
        ImageDraw.Draw(image).rectangle((5 + 8 * frame, 20, 25 + 8 * frame, 50), fill=(150, 60, 50))
        pictures.append(image)
    path.parent.mkdir(parents=True, exist_ok=True)
    pictures[0].save(path, "WEBP", save_all=True, append_images=pictures[1:], duration=100, loop=0)


def films(folder: Path, roles: list[str]) -> None:
    """A success and a failure per asset and their list, and the archive of them."""
    from roomkin.plugins.films.kinds import Film, Films

    entries = []
    for role in roles:
        for number, success in enumerate((True, False)):
            name = f"{role}_{number}.webp"
            film(folder / name)
            entries.append(
                Film(role=role, asset="cabinet_07", seed=number, success=success, steps=23, opened=0.12, file=name)
            )
    write_json(folder / "films.json", Films(films=entries))
    pack(folder, folder.with_suffix(".zip"))


def snapshots(folder: Path, assets: list[str]) -> None:
    """A shard: every asset a grey box on nothing, four yaws and the representative view."""
    yaws = [0.0, 1.57, 3.14, 4.71]
    shape = (len(assets), len(yaws) + 1, 24, 24)
    depth = np.zeros(shape, np.uint16)
    depth[:, :, 6:20, 4:18] = 900
    folder.mkdir(parents=True, exist_ok=True)
    with h5py.File(folder / "shard_0.h5", "w") as file:
        file["rgb"], file["depth"] = np.full((*shape, 3), 120, np.uint8), depth
    camera = [[40.0, 0.0, 11.5], [0.0, 40.0, 11.5], [0.0, 0.0, 1.0]]
    shard = SnapshotShard(assets=assets, yaws=yaws, representative_yaw=-0.5, image_size=24, intrinsics=camera)
    write_json(folder / "shard_0.json", shard)
    picture(folder / "shard_0.png", 600, 400, seed=8)


def write_rows(path: Path, rows: list[BaseModel]) -> Path:
    """Rows as `evaluation` writes them: a CSV with empty cells for None."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, type(rows[0]).model_fields, lineterminator="\n")
        writer.writeheader()
        writer.writerows(row.model_dump() for row in rows)
    return path


def score(scene: str = "room_1", number: int = 1, **changes: object) -> SceneScore:
    """A score of a well placed object in row (b) of the paper's Table 2."""
    values = {
        "scene": scene, "variant": "b", "rank": 1, "scale_m": 3.68, "object": f"object_{number}", "status": "ok",
        "true_asset": f"asset_{number}", "asset": f"asset_{number}", "category_correct": True, "model_correct": True,
        "l2_cm": 4.0 + number, "orientation_rad": 0.05, "orientation_paper_rad": 0.05,
        "iou": 0.7, "oriented_iou": 0.6, "stable": True,
    }  # fmt: skip
    return SceneScore.model_validate(values | changes)


def rollout(episode: int = 0, success: bool = True, **changes: object) -> Rollout:
    """A rollout on the twin of a policy that was trained on it; every role is an asset of a family of its own."""
    asset = changes.get("asset", f"cabinet_{changes.get('test_asset', 'twin')}")
    values = {
        "target": "door", "task": "door", "cloud": "target_link", "policy": "lite", "training_set": "twin",
        "run": "lite", "seed": 0, "checkpoint": "best", "test_asset": "twin", "asset": asset, "family": asset,
        "handle": "bar", "handle_length": 0.12, "feature_distance": 0.0, "episode": episode,
        "initial_state": 1000 + episode, "success": success, "official_success": success, "steps": 80, "opened": 0.9,
    }  # fmt: skip
    return Rollout.model_validate(values | changes)


def rollouts() -> list[BaseModel]:
    """Two training sets with two seeds on four test assets and their own, ten episodes each; cousins fall less."""
    rows: list[BaseModel] = []
    chance = {"twin": [0.9, 0.7, 0.5, 0.3], "cousins_4": [0.9, 0.9, 0.8, 0.6]}
    rng = np.random.default_rng(5)
    for name, rates in chance.items():
        for seed in (0, 1):
            for role, rate in zip(["twin", "cousin_2", "cousin_6", "dissimilar"], rates, strict=True):
                same = {"training_set": name, "seed": seed, "test_asset": role, "feature_distance": ROLES[role]}
                rows += [rollout(episode, bool(rng.random() < rate), **same) for episode in range(10)]
            same = {"training_set": name, "seed": seed, "test_asset": "trained"}
            rows += [rollout(episode, episode < 9, **same) for episode in range(10)]
    return rows


HANDLES = [("knob", 0.03), ("arch", 0.08), ("bar", 0.15), ("edge", 0.4)]


def over_assets(
    policies: dict[tuple[str, str], float], assets: int = 24, split: str = "test", target: str = "door"
) -> list[Rollout]:
    """Two seeds of each policy on unseen assets, twice each; long handles are easy. The skill opens all.

    Args:
        policies: (policy, training set) -> handles longer than this (metres) are opened, and every third of the others.
    """
    rows = []
    for (policy, name), length in policies.items():
        for seed in (0,) if name == "skill" else (0, 1):
            of = {"seed": seed, "training_set": name, "target": target, "policy": policy, "test_asset": split}
            of |= {"run": "scripted", "checkpoint": "none"} if name == "skill" else {"run": policy}
            for number in range(assets):
                handle, extent = HANDLES[number % 4]
                at = {"asset": f"wall_cabinet_{number:02d}", "family": f"wall_cabinet_{number // 2:02d}"}
                at |= {"handle": handle, "handle_length": extent, "feature_distance": 2 + number % 7}
                opened = extent > length or (number + seed) % 3 == 0
                rows += [rollout(2 * number + n, opened, initial_state=5000 + n, **of, **at) for n in (0, 1)]
    return rows


UNSEEN = {
    ("lite", "twin"): 0.2, ("lite", "cousins_4"): 0.1, ("lite_handle", "twin"): 0.05,
    ("lite_handle", "cousins_4"): 0.05, ("skill", "skill"): 0.0,
}  # fmt: skip


def _room(results: Path, name: str) -> None:
    picture(results / "scenes" / name / "input" / "rgb.png", seed=1)
    picture(results / "extraction" / name / "overview.png", 720, 160, seed=2)
    labels = LABELS[name]
    box = Box(center=(2.0, 0.0, 0.5), size=(0.6, 0.4, 1.0), yaw=0.1)
    seen = [
        SceneObject(id=f"{label}_1", label=label, mask=number, box=box, doors=2 if label == "cabinet" else 0,
                    pixels=(40 * number, 30, 40 * number + 60, 120), mounting=Mounting(type=3 if number == 1 else 2))
        for number, label in enumerate(labels, start=1)
    ]  # fmt: skip
    seen.append(
        SceneObject(id="vase_1", label="vase", mask=9, status="failed", reason="only 12 points <after cleaning>")
    )
    frame = {"width": 240, "height": 160, "intrinsics": CAMERA, "floor_from_camera": POSE, "walls": []}
    write_json(results / "extraction" / name / "objects.json", Objects(scene=name, objects=seen, **frame))

    view = Orientation(yaw=0.2, distance=8.0)
    found = [
        ObjectCousins(id=item.id, label=item.label, decided_by="geometry", orientation_decided_by="geometry", cousins=[
            Cousin(rank=rank, asset=f"{item.label}_{rank:02d}", category=item.label, distance=6.0 + rank,
                   votes=9 - rank, orientation=view, orientations=[view]) for rank in range(1, 8)])
        for item in seen[:-1]
    ]  # fmt: skip
    found.append(ObjectCousins(id="vase_1", label="vase", status="failed", reason="no cloud"))
    matching = results / "matching" / "default" / name
    write_json(matching / "cousins.json", Cousins(scene=name, encoder="hog", objects=found))
    picture(matching / "cousins.png", 700, 300, seed=3)

    generation = results / "generation" / "default" / name
    picture(generation / "comparison.png", 700, 240, seed=4)
    for rank in (1, 2):
        placed = [
            PlacedObject(id=item.id, label=item.label, asset=item.id, category=item.label, size=(1, 1, 1), moved=0.04)
            for item in seen[:-1]
        ]
        fallen = ["lamp_1"] if rank == 2 and "lamp" in labels else []
        check = Plausibility(seconds=2, stable=not fallen, fallen=fallen, mean_displacement=0.004,
                             max_penetration=0.001, collisions=0)  # fmt: skip
        scene = GeneratedScene(
            scene=name, variant="default", rank=rank, objects=placed, plausibility=check, made=MADE, **frame
        )
        write_json(generation / f"scene_{rank}.json", scene)
        picture(generation / f"scene_{rank}.png", seed=10 + rank)


def _policies(results: Path) -> None:
    from roomkin.plugins.films.kinds import Films
    from roomkin.plugins.in_scene.kinds import SceneDemonstration, SceneDemonstrations

    assets = [
        TaskAsset(role=role, asset=f"cabinet_{number:02d}", category="cabinet", joint="door", size=(0.5, 0.6, 0.7),
                  distance=distance, family=f"cabinet_{number:02d}", **ABOUT)
        for number, (role, distance) in enumerate(ROLES.items())
    ]  # fmt: skip
    chosen = TaskAssets(task="door", scene="room_1", object="cabinet_1", encoder="hog", assets=assets)
    write_json(results / "experiment" / "default" / "door" / "assets.json", chosen)
    for role in ("twin", "cousin_1"):
        folder = results / "demonstrations" / "door" / role
        films(folder / "films", [role])
        causes = ["success"] * 8 + ["grasp_slip", "approach"]
        attempts = [
            Attempt(
                attempt=n, asset="cabinet_01", seed=n, success=cause == "success", cause=cause, steps=60, opened=0.8
            )
            for n, cause in enumerate(causes)
        ]
        (folder / "attempts.jsonl").write_text("".join(attempt.model_dump_json() + "\n" for attempt in attempts))
    folder = results / "demonstrations" / "door" / "in_scene"
    films(folder / "films", ["rank_1"])
    film = read_json(Films, folder / "films" / "films.json").films[0]
    about = {"scene": "room_1", "variant": "default", "asset": "cabinet_01"}
    done = [
        SceneDemonstration(**about, rank=1, status="ok", attempts=1, film=film),
        SceneDemonstration(**about, rank=2, status="failed", reason="the robot cannot open it: sofa_1 is in its place"),
    ]
    write_json(folder / "in_scene.json", SceneDemonstrations(task="door", object="cabinet_1", demonstrations=done))
    for name in ("twin", "cousins_4"):
        folder = results / "training" / "door" / "lite" / name / "lite" / "seed_0"
        folder.mkdir(parents=True)
        lines = [
            {"step": s, "train_loss": 5 - s / 300, "valid_loss": 5 - s / 400, "lr": 1e-3} for s in range(0, 900, 50)
        ]
        (folder / "metrics.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        films(
            results / "evaluation" / "policies" / "door" / "lite" / name / "lite" / "seed_0" / "films",
            ["twin", "dissimilar"],
        )


def write_run(root: Path) -> Path:
    """Write results/, benchmarks/ and rows to score under `root`; returns `root`."""
    results = root / "results"
    for name in LABELS:
        _room(results, name)
    models = [
        LibraryEntry(id=f"{category}_{number:02d}", category=category, archive="x.zip", doors=category == "cabinet",
                     drawers=0, checksum="0")
        for category, count in (("cabinet", 9), ("bowl", 4)) for number in range(count)
    ]  # fmt: skip
    write_json(results / "assets" / "library" / "library.json", Library(assets=models))
    names = {label for labels in LABELS.values() for label in labels}
    snapshots(results / "assets" / "snapshots", sorted(f"{name}_{rank:02d}" for name in names for rank in range(1, 8)))
    _policies(results)

    scenes = results / "evaluation" / "scenes" / "default"
    ours = {"variant": "default"}
    lost = ours | {"status": "missed", "asset": "", "category_correct": False, "model_correct": False}
    lost |= dict.fromkeys(["l2_cm", "orientation_rad", "orientation_paper_rad", "iou", "oriented_iou", "stable"])
    write_rows(
        scenes / "room_1" / "scores.csv",
        [score(number=1, **ours), score(number=2, model_correct=False, **ours), score(number=3, **lost)],
    )
    write_rows(
        scenes / "room_2" / "scores.csv",
        [score("room_2", n, scale_m=3.42, orientation_rad=None, orientation_paper_rad=None, **ours) for n in (1, 2)],
    )
    write_rows(results / "evaluation" / "policies" / "door" / "rollouts.csv", rollouts())
    write_rows(results / "evaluation" / "policies" / "unseen" / "rollouts.csv", list(over_assets(UNSEEN)))

    header = "s\th:m:s\tmax_rss\tmax_vms\tmax_uss\tmax_pss\tio_in\tio_out\tmean_load\tcpu_time\n"
    for name, seconds, memory in (("assets/library", 61.5, 300.25), ("matching/default/room_1", 12.0, 800.0)):
        path = root / "benchmarks" / f"{name}.tsv"
        path.parent.mkdir(parents=True)
        path.write_text(header + f"{seconds}\t0:01:01\t{memory}\t1\t1\t1\t0\t0\t90\t{seconds * 0.9}\n")
    short = root / "benchmarks" / "tables" / "tables.tsv"
    short.parent.mkdir()
    short.write_text(f"{header}0.4\t0:00:00\tNA\tNA\tNA\tNA\tNA\tNA\tNA\tNA\n")
    return root


def declared(root: Path) -> dict[str, object]:
    """What the rule of the page names: all files of the run, as arguments of the command."""
    results = root / "results"
    files = [path for path in results.rglob("*") if path.is_file() and path.parent.name not in ("films", "report")]
    return {
        "files": tuple(files),
        "images": tuple(f"{room}={results}/scenes/{room}/input/rgb.png" for room in LABELS),
        "benchmarks": tuple(path for path in (root / "benchmarks").rglob("*") if path.is_file()),
        "benchmarks_root": root / "benchmarks",
    }
