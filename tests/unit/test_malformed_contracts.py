"""Broken JSON documents, tables and ledgers: each refused in one line that names file and field."""

import json
from pathlib import Path
from typing import Any

import pytest

from roomkin.stages.contracts.__main__ import main
from roomkin.stages.contracts.kinds import KINDS
from tests.unit.contract_files import FILES, POSE, Bench

NAN, INF = float("nan"), float("inf")
DELETE = object()
MIRRORED = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
LARGER = [[1.01, 0.0, 0.0, 0.0], [0.0, 1.01, 0.0, 0.0], [0.0, 0.0, 1.01, 0.0], [0.0, 0.0, 0.0, 1.0]]
SHEARED = [[1.0, 0.02, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
SCALED = [[2.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
K3 = [[50.0, 0.0, 23.5], [0.0, 50.0, 17.5], [0.0, 0.0, 1.0]]


def test_every_kind_has_a_valid_example(valid: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert set(FILES) == set(KINDS)
    for kind, name in FILES.items():
        assert main([kind, str(valid / name)]) == 0, capsys.readouterr().err


def put(content: Any, where: str, value: object) -> None:
    """Set the entry at a dotted path, or take it away."""
    *parents, last = [int(part) if part.isdigit() else part for part in where.split(".")]
    for part in parents:
        content = content[part]
    if value is DELETE:
        del content[last]
    else:
        content[last] = value


DOCUMENTS = ["camera", "annotations", "truth", "objects", "cousins", "distances", "generated", "task", "library",
             "asset", "snapshots", "features", "policy", "chosen", "in_scene"]  # fmt: skip
DOCUMENTS = [kind for kind in DOCUMENTS if kind in FILES]


@pytest.mark.parametrize("kind", DOCUMENTS)
@pytest.mark.parametrize(
    ("value", "words"),
    [(DELETE, "names no version"), (2, "is version 2; this workflow reads version 1"), ("1", "version"),
     (True, "version")],
    ids=["missing", "newer", "text", "bool"],
)  # fmt: skip
def test_another_version(bench: Bench, kind: str, value: object, words: str) -> None:
    bench.edit(kind, lambda content: put(content, "version", value))
    bench.refused(kind, FILES[kind].split("/")[-1], words)


@pytest.mark.parametrize("kind", [*DOCUMENTS, "attempts", "metrics", "rollouts", "scores"])
@pytest.mark.parametrize(
    "text", [b"", b"{", b"[]", b"\xff\xfe\x00", b"[" * 5000], ids=["empty", "cut", "list", "bytes", "deep"]
)
def test_no_document(bench: Bench, kind: str, text: bytes) -> None:
    bench.path(kind).write_bytes(text)
    bench.refused(kind, bench.path(kind).name)


@pytest.mark.parametrize("kind", list(FILES))
def test_no_file(bench: Bench, kind: str) -> None:
    bench.path(kind).unlink()
    bench.refused(kind, bench.path(kind).name, "no such file")


FIELDS: dict[str, list[tuple]] = {  # kind of file: entry, value, what the line names (default: the entry)
    "camera": [
        ("width", 0), ("width", -48), ("width", 48.5), ("height", 10**9), ("width", "48"), ("fov", 1.0),
        ("height", None), ("intrinsics", [[]]), ("intrinsics", []), ("intrinsics", K3[:2]),
        ("intrinsics", [[*row, 0.0] for row in K3]), ("intrinsics.0.0", NAN), ("intrinsics.0.0", INF),
        ("intrinsics.0.0", 0.0), ("intrinsics.1.1", -50.0), ("intrinsics.2.2", 2.0),
        ("intrinsics.0.0", 0.9, "fx 0.9"), ("intrinsics.1.1", 0.5, "fy 0.5"), ("intrinsics.1.1", 20.0, "fy 20"),
        ("intrinsics.0.0", 2000.0, "fx 2000"), ("intrinsics.0.1", 3.0), ("intrinsics.0.2", 1e9),
        ("intrinsics.0.2", 300.0, "cx 300"), ("intrinsics.1.2", 1.0, "cy 1"),
    ],
    "films": [
        ("films.0.file", "../twin_5.webp"), ("films.0.file", "none.webp", "none.webp"), ("films.0.seed", -1),
        ("films.1.file", "twin_5.webp", "files"), ("films.0.opened", NAN), ("films.0.steps", "6"),
    ],
    "in_scene": [
        ("demonstrations", []), ("demonstrations.1.rank", 1, "ranks"), ("demonstrations.0.film", None, "film"),
        ("demonstrations.1.reason", "", "reason"), ("demonstrations.0.shift", [0.0]), ("demonstrations.0.rank", 0),
    ],
    "annotations": [
        ("objects", []), ("objects.0.mask", 0), ("objects.0.mask", 70000), ("objects.0.mask", 1.5),
        ("objects.1.mask", 1, "mask values"), ("floor", 1, "mask values"), ("walls", [4, 4], "mask values"),
        ("objects.0.mounting", {"type": 1, "walls": []}, "mounting"),
        ("objects.0.mounting", {"type": 2, "walls": [4]}, "mounting"),
        ("objects.0.mounting", {"type": 3, "walls": [3]}, "3 is not in walls"),
        ("objects.0.doors", -1), ("objects.0.doors", 10**6), ("objects.0.label", ""), ("objects.0.label", 7),
        ("objects.0.articulated", "yes"),
        ("objects.0.articulated", False), ("objects.0.articulated", DELETE),
    ],
    "truth": [
        ("objects", []), ("scale", NAN), ("scale", -1.0), ("world_from_camera", POSE[:3]),
        ("world_from_camera", LARGER), ("world_from_camera", SHEARED),
        ("world_from_camera", MIRRORED), ("objects.0.position.1", NAN), ("objects.0.size.0", 0.0),
        ("objects.0.size.2", -1.0), ("objects.0.size.0", 400.0), ("objects.0.yaw", INF), ("objects.0.yaw", 90.0),
        ("objects.1.support", "9"), ("objects.0.support", "2", "circle"), ("objects.1.mask", 1, "mask values"),
        ("objects.0.symmetry", "some"), ("objects.0.asset", "../../etc"),
    ],
    "objects": [
        ("floor_from_camera", [[]]), ("floor_from_camera", SCALED), ("floor_from_camera", MIRRORED),
        ("floor_from_camera.3", [0, 0, 0, 2.0]), ("floor_from_camera.0.3", 5000.0), ("floor_from_camera.0.3", NAN),
        ("walls.0.normal", [0.0, 0.0, 1.0]), ("walls.0.normal", [2.0, 0.0, 0.0]), ("walls.0.offset", NAN),
        ("walls.0.id", "wall_2", "wall_1"), ("objects.1.id", "cabinet_1", "ids"),
        ("objects.1.mask", 1, "mask values"), ("objects.0.id", "a/b"), ("objects.0.id", ".."),
        ("objects.0.box", None), ("objects.0.mounting", None), ("objects.0.box.size.1", -0.5, "size"),
        ("floor_from_camera.2.3", -1.4, "not above the floor"), ("walls.0.normal", [1.0, 0.0, 0.0], "m away from it"),
        ("walls.0.offset", 3.0, "behind 'wall_1'"), ("objects.0.box.yaw", 3.0, "within pi/4"),
        ("objects.0.box.size.1", 1e30, "size"), ("objects.0.box.center.0", NAN, "center"), ("objects.0.box.yaw", NAN),
        ("objects.0.mounting.type", 4), ("objects.0.mounting.walls", ["wall_9"], "wall_9"),
        ("objects.0.pixels", [20, 10, 5, 30]), ("objects.0.pixels", [5, 10, 20, 99]), ("objects.0.pixels", [1, 2, 3]),
        ("objects.2.reason", ""), ("objects.0.status", "fine"), ("objects.0.doors", -3), ("intrinsics", [[1.0]]),
        ("objects.1.measured_support", "table_9", "table_9"), ("objects.1.measured_support", "bowl_1", "circle"),
        ("depth_error", [0.1, -1.0]),
    ],
    "cousins": [
        ("objects.0.cousins.0.rank", -7), ("objects.0.cousins.1.rank", 3, "ranks"),
        ("objects.0.cousins.0.rank", 2, "ranks"), ("objects.0.cousins.0.distance", NAN),
        ("objects.0.cousins.0.distance", -1.0), ("objects.0.cousins.0.distance", 9.0, "distance"),
        ("objects.0.by_distance.0.distance", 9.0, "by_distance"), ("objects.0.cousins.0.asset", "../../etc"),
        ("objects.0.cousins.1.asset", "cabinet_0", "cabinet_0"), ("objects.1.id", "cabinet_1", "ids"),
        ("objects.0.cousins", []), ("objects.0.cousins.0.orientation.yaw", INF),
        ("objects.0.cousins.0.orientation.yaw", 359.0), ("objects.0.cousins.0.votes", -2), ("objects.1.reason", ""),
        ("objects.0.cousins.0.orientation", DELETE), ("objects.0.categories.0.distance", NAN),
    ],
    "distances": [
        ("assets", ["cabinet_0", "cabinet_0"]), ("distances.cabinet_0", [0.0]), ("distances.cabinet_0.1", NAN),
        ("distances.cabinet_0.1", -1.0), ("distances", []),
    ],
    "generated": [
        ("rank", 0), ("rank", -1), ("objects.0.size", [0.0, 0.6, 1.0]), ("objects.0.size", [0.5, 0.6, 400.0]),
        ("objects.0.size.0", NAN), ("objects.0.position.0", 1e6), ("objects.0.yaw", NAN), ("objects.0.asset", ""),
        ("objects.1.support", "table_9"), ("objects.1.support", "lamp_1"), ("objects.0.support", "bowl_1", "circle"),
        ("objects.1.support", "bowl_1", "circle"), ("objects.1.id", "cabinet_1", "ids"),
        ("plausibility.fallen", ["nobody"]), ("plausibility.mean_displacement", NAN), ("plausibility.collisions", -1),
        ("objects.0.mounting.walls", ["wall_9"], "wall_9"), ("objects.0.moved", -0.1), ("floor_from_camera", []),
        ("floor_from_camera.2.3", 0.0, "not above the floor"), ("walls.0.offset", 3.0, "behind 'wall_1'"),
        ("objects.2.reason", ""),
    ],
    "task": [
        ("assets", []), ("assets.0.role", "cousin_3", "roles"), ("assets.1.role", "cousin_2", "roles"),
        ("assets.1.asset", "cabinet_0"), ("assets.1.distance", 5.0, "distance"), ("assets.0.distance", NAN),
        ("assets.0.size.0", -0.5, "size"), ("assets.0.size", [1.0, 1.0]), ("assets.0.joint", ""), ("task", "../door"),
        ("assets.2.role", "friend", "roles"),
    ],
    "chosen": [
        ("runs", []), ("runs", ["narrow"], "narrow was not tried"), ("runs", ["lite", "lite"]),
        ("scores.1.run", "lite"), ("scores.0.episodes", 0), ("scores.0.successes", -1), ("target", "../door"),
    ],
    "library": [
        ("assets", []), ("assets.0.archive", "../../etc"), ("assets.0.archive", "/etc"),
        ("assets.0.archive", "models\\..\\x"), ("assets.0.archive", ""), ("assets.0.archive", "a\u0000b"),
        ("assets.1.id", "bowl_0", "ids"), ("assets.0.doors", -3), ("assets.0.category", ""),
    ],
    "shards": [("shards", []), ("shards.0", ""), ("shards.1", "0", "shards: "), ("shards", "0")],
    "library_part": [
        ("assets.0.archive", "../own_0.zip"), ("assets.1.id", "bowl_0", "ids"), ("assets.0.doors", 2, "doors"),
        ("assets.0.id", "bowl_1", "holds no bowl_1/asset.json"), ("assets.0.checksum", "other", "checksum"),
        ("assets.0.archive", "none.zip", "no such file"), ("assets.0.archive", "own_0.json", "no zip archive"),
    ],
    "asset": [
        ("urdf", "../model.urdf"), ("urdf", "none.urdf"), ("box_max.0", NAN), ("box_max.0", -0.25, "box_max"),
        ("box_max.0", 400.0, "box_max"), ("mass", 1e30), ("mass", INF), ("mass", 0.0), ("mass", -1.0), ("doors", 2),
        ("drawers", -3), ("joints.0.upper", 1e30), ("joints.0.lower", 2.0), ("joints.0.axis", [0.0, 0.0, 0.0]),
        ("joints.0.axis", [0.0, 0.0, NAN]), ("joints.0.type", "floating"), ("recipe.parameters.size", {"x": 1}),
        ("recipe.parameters.shelves", NAN), ("recipe.generator", ""), ("symmetry", "round"),
    ],
    "snapshots": [
        ("assets", ["cabinet_0", "cabinet_0"]), ("yaws", []), ("yaws", [0.0, 0.0]), ("yaws.0", NAN),
        ("image_size", 0), ("intrinsics", [[1.0]]), ("elevation", "low"),
    ],
    "features": [
        ("starts", [0]), ("starts.1", 9), ("starts.0", 1), ("starts.1", -1), ("yaws", []), ("assets", ["a", "a"]),
    ],
    "policy": [
        ("parameters", 25), ("parameters", -1), ("checkpoints", ["../../x"]),
        ("checkpoints", ["none.safetensors"], "none.safetensors: no such file"), ("stores", []), ("best_loss", NAN),
        ("config.steps", 0), ("config.kwargs", "big"), ("task_options.points", 3), ("seed", -1),
    ],
}  # fmt: skip
CASES = [(kind, *case) for kind, cases in FIELDS.items() if kind in FILES for case in cases]


@pytest.mark.parametrize(
    "case", CASES, ids=[f"{case[0]}-{case[1]}-{'absent' if case[2] is DELETE else str(case[2])[:24]}" for case in CASES]
)
def test_a_field(bench: Bench, case: tuple) -> None:
    kind, where, value, *words = case
    bench.edit(kind, lambda content: put(content, where, value))
    named = words or [next(part for part in reversed(where.split(".")) if not part.isdigit())]
    bench.refused(kind, str(bench.root), *named)


@pytest.mark.parametrize(
    ("kind", "old", "new", "words"),
    [
        ("attempts", '"attempt": 1', '"attempt": 7', "attempts.jsonl:2: attempt"),
        ("attempts", '"attempt": 1', '"attempt": -1', "attempts.jsonl:2"),
        ("attempts", '"episode": 1', '"episode": 4', "attempts.jsonl:3: episode"),
        ("attempts", '"opened": 0.1', '"opened": NaN', "opened"),
        ("attempts", '"opened": 0.1', '"opened": 1e9', "opened"),
        ("attempts", '"success": false', '"success": "no"', "success"),
        ("attempts", '"steps": 9, ', "", "steps"),
        (
            "attempts",
            '"cause": "grasp"',
            '"cause": "success"',
            "attempts.jsonl:2: breaks the Attempt contract at cause",
        ),
        (
            "attempts",
            '"cause": "success"',
            '"cause": "grasp"',
            "attempts.jsonl:1: breaks the Attempt contract at cause",
        ),
        (
            "attempts",
            '"success": true, "cause": "success"',
            '"success": false, "cause": "grasp"',
            "attempts.jsonl:1: episode: is 0, but the attempt did not succeed",
        ),
        ("attempts", '"seed": 6', '"seed": -6', "seed"),
        ("attempts", '{"attempt": 1', 'x{"attempt": 1', "attempts.jsonl:2"),
        ("metrics", '"step": 200', '"step": 100', "metrics.jsonl:2: step"),
        ("metrics", '"step": 200, ', "", "metrics.jsonl:2"),
        ("metrics", '"loss": 0.005', '"loss": NaN', "loss"),
        ("metrics", '"loss": 0.005', '"loss": "low"', "loss"),
        ("rollouts", "steps,opened", "steps", "lacks the column 'opened'"),
        ("rollouts", "steps,opened", "steps,opened,more", "unknown column 'more'"),
        ("rollouts", "steps,opened", "opened,opened", "column"),
        ("rollouts", "steps,opened", "steps,opened,opened", "has a column twice"),
        ("rollouts", "60,0.9", "60,nan", "rollouts.csv:2"),
        ("rollouts", "60,0.9", "60,inf", "opened"),
        ("rollouts", "60,0.9", "sixty,0.9", "steps"),
        ("rollouts", "60,0.9", "60", "rollouts.csv:2: has more or fewer cells"),
        ("rollouts", "60,0.9", "60,0.9,1", "rollouts.csv:2: has more or fewer cells"),
        ("rollouts", "True,True,60", "maybe,True,60", "success"),
        ("rollouts", "door,target_link,", "door,everything,", "cloud"),
        ("rollouts", "0.0,1,2147483649", "-1,1,2147483649", "rollouts.csv:3"),
        ("rollouts", "0.0,1,2147483649", "0.0,,2147483649", "episode"),
        ("rollouts", "door,door,target_link,lite,twin,lite,0,best,twin", 'door,"twin,lite,0', "rollouts.csv"),
        ("rollouts", "0.0,1,2147483649", "0.0,0,2147483649", "rollouts.csv:3: is line 2 again"),
        ("scores", "3.68,lamp_1", "3.68,cabinet_1", "scores.csv:3: is line 2 again"),
        ("scores", "3.68,lamp_1", "nan,lamp_1", "scale_m"),
        ("scores", ",failed,", ",lost,", "status"),
        ("scores", "2.1,0.01", "-2.1,0.01", "l2_cm"),
        ("scores", "2.1,0.01", "2.1,7", "orientation_rad"),
        ("scores", "0.9,0.9", "1.9,0.9", "iou"),
        ("scores", "b,1,3.68,cabinet_1", "b,0,3.68,cabinet_1", "rank"),
    ],
)
def test_a_line(bench: Bench, kind: str, old: str, new: str, words: str) -> None:
    text = bench.path(kind).read_text()
    assert old in text
    bench.path(kind).write_text(text.replace(old, new, 1))
    bench.refused(kind, bench.path(kind).name, words)


@pytest.mark.parametrize("kind", ["rollouts", "scores"])
def test_a_table_without_rows(bench: Bench, kind: str) -> None:
    bench.path(kind).write_text(bench.path(kind).read_text().splitlines()[0] + "\n")
    bench.refused(kind, "has no rows")


def test_a_byte_order_mark_is_no_fault(bench: Bench) -> None:
    text = json.dumps(json.loads(bench.path("camera").read_text()))
    bench.path("camera").write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert main(["camera", str(bench.path("camera"))]) == 0
