"""A small valid file of every kind that passes between stages, for tests that break them one by one."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from PIL import Image
from safetensors.numpy import save_file

from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.kinds import KINDS
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from tests.unit.demo_assets import FRONT

WIDTH, HEIGHT = 48, 36
K = [[50.0, 0.0, 23.5], [0.0, 50.0, 17.5], [0.0, 0.0, 1.0]]
POSE = [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 1.5], [0.0, 0.0, 0.0, 1.0]]
CLOUD = np.random.default_rng(0).uniform([1.8, -0.2, 0.1], [2.2, 0.2, 0.9], (50, 3)).astype(np.float32)
HAND = np.full((6, 9), 0.5, np.float32)  # proprioception: its quaternion is a turn
FILES = {  # kind of file: where it lies
    "camera": "input/camera.json",
    "annotations": "input/annotations.json",
    "things": "input/things.json",
    "corrections": "input/corrections.json",
    "truth": "truth.json",
    "objects": "extraction/objects.json",
    "shards": "matching/shards.json",
    "cousins": "matching/cousins.json",
    "distances": "matching/distances.json",
    "generated": "generation/scene_1.json",
    "task": "experiment/assets.json",
    "library": "library/library.json",
    "library_part": "library/own_0.json",
    "asset": "library/models/cabinet_0/asset.json",
    "snapshots": "snapshots/shard_0.json",
    "features": "features/shard_0.json",
    "attempts": "demonstrations/attempts.jsonl",
    "episodes": "demonstrations/episodes.h5",
    "films": "demonstrations/films/films.json",
    "in_scene": "demonstrations/in_scene.json",
    "policy": "training/config.json",
    "metrics": "training/metrics.jsonl",
    "chosen": "evaluation/chosen.json",
    "rollouts": "evaluation/rollouts.csv",
    "scores": "evaluation/scores.csv",
}
FILES = {kind: file for kind, file in FILES.items() if kind in KINDS}  # those of packages that are here


def write_files(root: Path) -> Path:
    """Write them all below `root`."""
    for write in (_input, _extraction, _matching, _library, _policies, _evaluation):
        write(root)
    return root


def _json(path: Path, **content: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"version": 1, **content}, indent=1))


def masks() -> np.ndarray:
    """Two objects (1, 2), the floor (3) and a wall (4)."""
    values = np.zeros((HEIGHT, WIDTH), np.uint16)
    values[:20], values[20:] = 4, 3
    values[10:30, 5:20], values[12:30, 25:40] = 1, 2
    return values


def _input(root: Path) -> None:
    folder = root / "input"
    _json(folder / "camera.json", width=WIDTH, height=HEIGHT, intrinsics=K)
    rng = np.random.default_rng(0)
    Image.fromarray(rng.integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)).save(folder / "rgb.png")
    Image.fromarray(masks()).save(folder / "masks.png")
    np.savez_compressed(folder / "depth.npz", depth=np.full((HEIGHT, WIDTH), 2.5, np.float32))
    annotations = [{"mask": 1, "label": "cabinet", "doors": 1, "articulated": True}, {"mask": 2, "label": "bowl"}]
    annotations[0]["mounting"] = {"type": 3, "walls": [4]}
    _json(folder / "annotations.json", objects=annotations, floor=3, walls=[4])
    names = [{"name": "bowl", "probability": 0.7}, {"name": "pot", "probability": 0.2}]
    bowl = {"mask": 2, "names": names, "other": 0.05, "score": 0.9, "source": "mobile_sam"}
    bag = {"mask": 5, "names": names[1:], "other": 0.6, "score": 0.8, "source": "ssd", "left_out": "no name is sure"}
    ground = {"camera_height": 1.5, "taken_from": "a level surface below which 0.3 % of the points lie", "share": 0.2}
    _json(folder / "things.json", ground=ground, walls=1, things=[bowl, bag])
    doors = [{"kind": "door", "left": k / 2, "right": (k + 1) / 2, "bottom": 0.1, "top": 1.0} for k in range(2)]
    told = [{"mask": 1, "panels": doors, "size": [0.8, 0.4, 0.9], "model": "cabinet_12", "banned": ["cabinet_3"]}]
    _json(folder / "corrections.json", objects=[*told, {"mask": 2, "on": 1, "nudge": [0.0, -0.05]}])


def _extraction(root: Path) -> None:
    box = {"center": [2.0, 0.0, 0.5], "size": [0.5, 0.6, 1.0], "yaw": 0.1}
    about = {"status": "ok", "pixels": [5, 10, 20, 30], "points": 50, "box": box}
    objects = [
        {"id": "cabinet_1", "label": "cabinet", "mask": 1, "mounting": {"type": 3, "walls": ["wall_1"]}, **about},
        {"id": "bowl_1", "label": "bowl", "mask": 2, "mounting": {"type": 2, "walls": []}, **about},
        {"id": "lamp_1", "label": "lamp", "mask": 5, "status": "failed", "reason": "too small"},
    ]
    walls = [{"id": "wall_1", "normal": [-1.0, 0.0, 0.0], "offset": -3.0, "points": 99}]
    frame = {"scene": "room", "width": WIDTH, "height": HEIGHT, "intrinsics": K, "floor_from_camera": POSE}
    folder = root / "extraction"
    _json(folder / "objects.json", **frame, walls=walls, objects=objects)
    Image.fromarray(np.where(masks() < 3, masks(), 0).astype(np.uint16)).save(folder / "masks.png")
    np.savez_compressed(folder / "depth.npz", depth=np.full((HEIGHT, WIDTH), 2.5, np.float32))
    np.savez_compressed(folder / "clouds.npz", cabinet_1=CLOUD, bowl_1=CLOUD)
    placed = {"status": "ok", "position": [2.0, 0.0, 0.5], "yaw": 0.1, "size": [0.5, 0.6, 1.0]}
    items = [
        {"id": "cabinet_1", "label": "cabinet", "asset": "cabinet_0", "category": "cabinet", "support": "floor",
         "mounting": {"type": 3, "walls": ["wall_1"]}, **placed},
        {"id": "bowl_1", "label": "bowl", "asset": "bowl_0", "category": "bowl", "support": "cabinet_1", **placed},
        {"id": "lamp_1", "label": "lamp", "status": "failed", "reason": "extraction: too small"},
    ]  # fmt: skip
    check = {"seconds": 2.0, "stable": True, "fallen": [], "mean_displacement": 0.0, "max_penetration": 0.0}
    _json(root / FILES["generated"], **frame, variant="default", rank=1, walls=walls, objects=items,
          plausibility={**check, "collisions": 0})  # fmt: skip
    true = {"category": "cabinet", "position": [1.0, 0.0, 0.5], "yaw": 0.0, "size": [0.5, 0.6, 1.0], "symmetry": "none"}
    objects = [{"mask": 1, "asset": "cabinet_0", "support": "floor", **true},
               {"mask": 2, "asset": "bowl_0", "support": "1", **true}]  # fmt: skip
    _json(root / "truth.json", scene="room", scale=2.5, world_from_camera=POSE, objects=objects)


def _matching(root: Path) -> None:
    _json(root / FILES["shards"], shards=["0", "part_16b3b4fa"])
    terms = {"outline": 0.9, "depth": 0.8, "lines": 0.8}
    view = {"yaw": 0.5, "distance": 1.0, "votes": 3, "score": 1.7, "terms": terms}
    models = [
        {"asset": f"cabinet_{n}", "category": "cabinet", "distance": 1.0 + n, "votes": 5 - n,
         "parts": {"patches": 0.75 + n, "size": 0.25}} for n in range(3)
    ]  # fmt: skip
    made = {"seed": None, "options": "0a1b2c3d4e5f", "inputs": "1b2c3d4e5f0a", "code": "2c3d4e5f0a1b"}
    cousins = [{"rank": n + 1, **model, "orientation": view, "orientations": [view]} for n, model in enumerate(models)]
    objects = [
        {"id": "cabinet_1", "label": "cabinet", "note": "count_threshold widened from 2 to 3",
         "decided_by": "distance", "by_votes": models, "by_distance": models, "orientation_decided_by": "geometry",
         "categories": [{"category": "cabinet", "distance": 0.0}], "cousins": cousins},
        {"id": "lamp_1", "label": "lamp", "status": "failed", "reason": "extraction: too small"},
    ]  # fmt: skip
    _json(root / FILES["cousins"], scene="room", encoder="hog", objects=objects, made=made)
    rows = {"cabinet_0": [0.0, 1.0], "cabinet_1": [1.0, 0.0]}
    _json(root / FILES["distances"], scene="room", object="cabinet_1", encoder="hog", assets=list(rows), distances=rows)
    yaws = [0.0, 3.0]
    _json(root / FILES["features"], encoder="hog", settings="abc", upright=True, assets=["cabinet_0", "bowl_0"],
          yaws=yaws, starts=[0, 2, 4, 6, 8, 10, 12])  # fmt: skip
    np.save(root / "features/shard_0.npy", np.ones((12, 4), np.float16))
    np.savez(root / "features/shard_0.npz", wholes=np.ones((6, 8), np.float16))
    _json(root / FILES["snapshots"], assets=["cabinet_0", "bowl_0"], yaws=yaws, representative_yaw=-0.5, image_size=16,
          intrinsics=[[20.0, 0.0, 7.5], [0.0, 20.0, 7.5], [0.0, 0.0, 1.0]], elevation=0.3)  # fmt: skip
    with h5py.File(root / "snapshots/shard_0.h5", "w") as file:
        file["rgb"] = np.ones((2, 3, 16, 16, 3), np.uint8)
        file["depth"] = np.full((2, 3, 16, 16), 900, np.uint16)


def _library(root: Path) -> None:
    panel = {"hinge": "left", "across": 0.3, "height": 0.5, "size": [0.56, 0.9]}
    joint = {"name": "door_joint", "type": "revolute", "role": "door", "parent": "base", "link": "door",
             "axis": [0.0, 0.0, 1.0], "lower": 0.0, "upper": 1.6, "panel": panel}  # fmt: skip
    entries = []
    for name, joints in (("bowl_0", []), ("cabinet_0", [joint])):
        folder = root / "library/models" / name
        about = {"category": name[:-2], "doors": len(joints), "drawers": 0, "checksum": "c0ffee"}
        recipe = {"generator": "cabinet", "parameters": {"size": [0.5, 0.6, 1.0], "panel": "flat", "shelves": 2}}
        _json(folder / "asset.json", id=name, **about, urdf="model.urdf", box_min=[-0.25, -0.3, 0.0],
              box_max=[0.25, 0.3, 1.0], mass=12.0, joints=joints, recipe=recipe, licence="CC0-1.0",
              provenance="test")  # fmt: skip
        (folder / "model.urdf").write_text(f'<robot name="{name}"><link name="base"/></robot>')
        entries.append({"id": name, "archive": "own_0.zip", **about})
    pack(root / "library/models", root / "library/own_0.zip")
    _json(root / FILES["library"], assets=entries)
    _json(root / FILES["library_part"], assets=entries, left_out=["chair.obj: is flat."])


def _films(root: Path, folder: Path) -> None:
    """Those of packages beside the core."""
    if not {"films", "in_scene"} <= set(FILES):
        return
    film = {"role": "twin", "asset": "cabinet_0", "success": True, "steps": 6, "opened": 0.8}
    films = [film | {"seed": seed, "file": f"twin_{seed}.webp"} for seed in (5, 7)]
    _json(root / FILES["films"], films=films)
    about = {"scene": "room", "variant": "default", "asset": "cabinet_0", "joint": "door_joint"}
    done = [
        {**about, "rank": 1, "status": "ok", "attempts": 2, "shift": [0.0, 0.12], "film": films[0]},
        {**about, "rank": 2, "status": "failed", "reason": "the robot cannot open it: table_1 is in its place (25x)"},
    ]
    _json(root / FILES["in_scene"], task="door", object="cabinet_1", demonstrations=done)
    for shot in films:
        (folder / "films" / str(shot["file"])).write_bytes(b"film")


def _policies(root: Path) -> None:
    sizes = {"size": [0.5, 0.6, 1.0], "category": "cabinet", "joint": "door_joint", **FRONT}
    roles = [("twin", "cabinet_0", 0.0), ("cousin_1", "cabinet_1", 1.0), ("cousin_2", "cabinet_2", 2.0)]
    assets = [{"role": role, "asset": asset, "family": asset, "distance": far, **sizes} for role, asset, far in roles]
    _json(root / FILES["task"], task="door", scene="room", object="cabinet_1", encoder="hog", assets=assets)
    folder = root / "demonstrations"
    folder.mkdir()
    lines = [
        {
            "attempt": 0,
            "asset": "cabinet_0",
            "seed": 5,
            "success": True,
            "cause": "success",
            "steps": 6,
            "opened": 0.8,
            "episode": 0,
        },
        {
            "attempt": 1,
            "asset": "cabinet_0",
            "seed": 6,
            "success": False,
            "cause": "grasp",
            "steps": 9,
            "opened": 0.1,
            "episode": None,
        },
        {
            "attempt": 2,
            "asset": "cabinet_0",
            "seed": 7,
            "success": True,
            "cause": "success",
            "steps": 6,
            "opened": 0.8,
            "episode": 1,
        },
    ]
    (folder / "attempts.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    options = TaskConfig(points=64)
    with h5py.File(folder / "episodes.h5", "w") as file:
        data = file.create_group("data")
        data.attrs.update(task="door", asset="cabinet_0", task_options=options.model_dump_json())
        for number in range(2):
            data[f"demo_{number}/obs/point_cloud"] = np.ones((6, 64, 4), np.float16)
            data[f"demo_{number}/obs/proprio"] = HAND
            data[f"demo_{number}/actions"] = np.full((6, 7), 0.5, np.float32)
            data[f"demo_{number}"].attrs["asset"] = "cabinet_0"
    _films(root, folder)
    folder = root / "training"
    store = {"file": "episodes.h5", "asset": "cabinet_0", "episodes": 2, "frames": 12}
    _json(folder / "config.json", task="door", task_options=options.model_dump(mode="json"),
          config=PolicyConfig().model_dump(mode="json"), seed=0, stores=[store], data_digest="d", training_episodes=2,
          validation_episodes=0, parameters=24, best_step=100, best_loss=-1.0, best_error=0.2,
          constant_error=0.5, plateau=0, checkpoints=[])  # fmt: skip
    for name in ("policy", "last"):
        save_file(weights(), folder / f"{name}.safetensors")
    rows = [{"step": step, "loss": 1.0 / step, "learning_rate": 1e-3} for step in (100, 200)]
    (folder / "metrics.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def weights() -> dict[str, np.ndarray]:
    """A network of one layer, with the normaliser."""
    one = np.ones(9, np.float32)
    normaliser = {"proprio_mean": one, "proprio_std": one, "cloud_mean": one[:3], "cloud_std": np.array(1, np.float32)}
    return {"head.weight": np.ones((4, 6), np.float32), **normaliser}


def _evaluation(root: Path) -> None:
    folder = root / "evaluation"
    folder.mkdir()
    (folder / "rollouts.csv").write_text(
        "target,task,cloud,policy,training_set,run,seed,checkpoint,test_asset,asset,family,handle,handle_length,"
        "feature_distance,episode,initial_state,success,official_success,steps,opened\n"
        "door,door,target_link,lite,twin,lite,0,best,twin,cabinet_0,cabinet_0,bar,0.2,0.0,0,2147483648,True,True,60,0.9\n"
        "door,door,target_link,lite,twin,lite,0,best,twin,cabinet_0,cabinet_0,bar,0.2,0.0,1,2147483649,False,True,99,0.2\n"
    )
    score = {"checkpoint": "best", "episodes": 20}
    scores = [{"run": "lite", "successes": 19, **score}, {"run": "wide", "successes": 3, **score}]
    _json(folder / "chosen.json", target="door", policy="lite", training_set="twin", runs=["lite"], scores=scores)
    (folder / "scores.csv").write_text(
        "scene,variant,rank,scale_m,object,status,true_asset,asset,category_correct,model_correct,l2_cm,"
        "orientation_rad,orientation_paper_rad,iou,oriented_iou,stable,shift_cm,penetration_cm,chamfer,shape_iou,"
        "panels_correct,handle_correct,hinge_correct,protocol,draw,model_judge,orientation_judge\n"
        "room,b,1,3.68,cabinet_1,ok,cabinet_0,cabinet_0,True,True,"
        "2.1,0.01,0.01,0.9,0.9,True,0.1,0,0.01,0.9,True,True,False,,0,vlm toy,distance\n"
        "room,b,1,3.68,lamp_1,failed,lamp_0,,False,False,,,,,,,,,,,,,,,0,,\n"
    )


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


class Bench:
    """Copies of the valid files, and the check that a broken one is refused in one line that names it."""

    def __init__(self, root: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.root, self.capsys = root, capsys

    def copy(self, source: Path) -> None:
        """Bring in one folder of the valid files."""
        shutil.copytree(source, self.root / source.name) if source.is_dir() else shutil.copy(source, self.root)

    def path(self, kind: str) -> Path:
        """The file of a kind."""
        return self.root / FILES[kind]

    def edit(self, kind: str, change: Callable[[Any], None]) -> None:
        """Change the content of a JSON file."""
        content = json.loads(self.path(kind).read_text())
        change(content)
        self.path(kind).write_text(json.dumps(content))

    def refused(self, kind: str, *words: str) -> None:
        """The check fails with one line with all `words`, and changes nothing."""
        before = contents(self.root)
        assert main([kind, str(self.path(kind))]) == 1
        error = self.capsys.readouterr().err
        assert error.startswith("error: ") and error.count("\n") == 1 and "Traceback" not in error
        for word in words:
            assert word in error, error
        assert contents(self.root) == before


def with_value(array: np.ndarray, value: float) -> np.ndarray:
    changed = array.copy()
    changed.reshape(-1)[7] = value
    return changed
