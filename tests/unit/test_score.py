"""Scores of generated scenes against a known truth (paper B.1)."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.stages.contracts import Asset, Cousins, GeneratedScene, Library, Objects, Truth, write_json
from roomkin.stages.contracts.__main__ import main as check_contract
from roomkin.stages.contracts.cousins import Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.generated import PlacedObject, Plausibility
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.evaluation.score import run
from roomkin.stages.evaluation.scoring import measure_likeness, score_scene
from roomkin.stages.geometry.frames import invert_transform, look_at, transform_points, yaw_of_matrix
from tests.refusals import refused

WORLD_FROM_CAMERA = look_at([5.0, 1.0, 1.6], [0.0, 0.0, 0.6])  # the room's frame
FLOOR_FROM_CAMERA = look_at([0.0, 0.0, 1.6], [np.hypot(5.0, 1.0), 0.0, 0.6])  # the floor frame of extraction
FLOOR_FROM_WORLD = FLOOR_FROM_CAMERA @ invert_transform(WORLD_FROM_CAMERA)
YAW = yaw_of_matrix(FLOOR_FROM_WORLD[:3, :3])


def true(mask: int, asset: str, position: tuple, yaw: float = 0.0, symmetry: str = "none") -> TrueObject:
    about = {"asset": asset, "category": asset[:-2], "size": (0.5, 1.0, 0.8), "support": "floor"}
    return TrueObject(mask=mask, position=position, yaw=yaw, symmetry=symmetry, **about)


TRUTH = Truth(
    scene="room_t", scale=3.5, world_from_camera=WORLD_FROM_CAMERA.tolist(),
    objects=[
        true(1, "cabinet_0", (0.3, 0.0, 0.4)), true(2, "chair_0", (2.0, 1.0, 0.4), yaw=0.5),
        true(3, "bowl_0", (1.0, -1.0, 0.4), symmetry="full"), true(4, "lamp_0", (1.0, 1.0, 0.4)),
        true(5, "vase_0", (0.0, 2.0, 0.4)),
    ],
)  # fmt: skip


def placed(name: str, of: TrueObject, asset: str, shift: tuple = (0, 0, 0), turn: float = 0.0) -> PlacedObject:
    """The true object as it would be in the floor frame, shifted (world frame) and turned."""
    position = transform_points(FLOOR_FROM_WORLD, np.array(of.position) + shift)
    about = {"label": name, "asset": asset, "category": asset[:-2], "size": of.size}
    return PlacedObject(id=name, position=tuple(position.tolist()), yaw=of.yaw + YAW + turn, **about)


def scene_and_objects() -> tuple[GeneratedScene, Objects]:
    names = {1: "cabinet_1", 2: "chair_1", 3: "bowl_1", 4: "lamp_1"}
    common = {"scene": "room_t", "width": 8, "height": 6, "floor_from_camera": FLOOR_FROM_CAMERA.tolist(), "walls": []}
    common["intrinsics"] = [[8.0, 0.0, 3.5], [0.0, 8.0, 2.5], [0.0, 0.0, 1.0]]
    about = {"box": Box(center=(0, 0, 0), size=(1, 1, 1), yaw=0), "mounting": Mounting(type=2)}
    items = [SceneObject(id=name, label=name, mask=mask, **about) for mask, name in names.items()]
    a, b, c = TRUTH.objects[:3]
    scene = GeneratedScene(
        variant="v",
        rank=1,
        objects=[
            placed("cabinet_1", a, "cabinet_0"),
            placed("chair_1", b, "chair_1", shift=(0.03, 0.04, 0.0), turn=0.2),
            placed("bowl_1", c, "plate_0", turn=1.0),
            PlacedObject(id="lamp_1", label="lamp_1", status="failed", reason="matching: no cousins"),
        ],
        plausibility=Plausibility(
            seconds=1.0, stable=False, fallen=["chair_1"], mean_displacement=0.1, max_penetration=0.0, collisions=0
        ),
        **common,
    )
    return scene, Objects(objects=items, **common)


def rows() -> dict:
    scene, seen = scene_and_objects()
    return {row.object: row for row in score_scene(scene, seen, TRUTH)}


def test_a_twin_in_its_place_is_perfect() -> None:
    row = rows()["cabinet_1"]
    assert row.category_correct and row.model_correct and row.stable is True and row.scale_m == 3.5
    assert [row.l2_cm, row.orientation_rad, row.iou, row.oriented_iou] == pytest.approx([0, 0, 1, 1], abs=1e-6)


def test_a_cousin_a_little_off() -> None:
    row = rows()["chair_1"]
    assert row.category_correct and not row.model_correct and row.stable is False
    assert row.l2_cm == pytest.approx(5.0)
    assert row.orientation_rad == row.orientation_paper_rad == pytest.approx(0.2)
    assert row.iou is not None and row.oriented_iou is not None and 0.5 < row.oriented_iou < 0.9


def test_what_any_turn_maps_onto_itself_has_no_orientation() -> None:
    row = rows()["bowl_1"]
    assert row.orientation_rad is None and row.orientation_paper_rad is None
    assert not row.category_correct


@pytest.mark.parametrize(("symmetry", "turn", "off"), [("third_turn", 2.2, 0.1056), ("half_turn", 3.0, 0.1416)])
def test_orientation_is_modulo_the_period_and_the_papers_count_leaves_it_out(
    symmetry: str, turn: float, off: float
) -> None:
    scene, seen = scene_and_objects()
    first = true(1, "cabinet_0", (0.3, 0.0, 0.4), symmetry=symmetry)
    turned = scene.model_copy(update={"objects": [placed("cabinet_1", first, "cabinet_0", turn=turn)]})
    row = score_scene(turned, seen, TRUTH.model_copy(update={"objects": [first]}))[0]
    assert row.orientation_rad == pytest.approx(off, abs=1e-3)
    assert row.orientation_paper_rad is None


def test_missed_and_failed_objects_count_as_wrong() -> None:
    table = rows()
    assert table["lamp_1"].status == "failed"
    assert table["mask_5"].status == "missed"
    for name in ("lamp_1", "mask_5"):
        row = table[name]
        assert not row.category_correct and not row.model_correct
        assert row.l2_cm is row.iou is row.stable is None
    assert len(table) == len(TRUTH.objects)


def test_models_are_compared_by_shape_and_by_what_they_offer(tmp_path: Path) -> None:
    recipe = sample("bottom_cabinet", 0, 0)
    wide = tuple(np.multiply(recipe.parameters["size"], (1, 1.4, 1)).tolist())
    true = build(recipe, None, tmp_path / "true", "a_0", "bottom_cabinet")
    build(recipe, wide, tmp_path / "wide", "a_1", "bottom_cabinet")
    build(sample("sofa", 0, 0), None, tmp_path / "sofa", "sofa_0", "sofa")
    same, wider, sofa = (measure_likeness(tmp_path / "true", tmp_path / name) for name in ("true", "wide", "sofa"))
    assert true.articulated and same == (0, 1, True, True, True)
    assert wider.chamfer < 0.01 and wider.shape_iou > 0.9 and wider[2:] == (True, True, True)
    assert sofa.chamfer > 2 * wider.chamfer and sofa.shape_iou < 0.8 and not sofa.panels_correct
    assert measure_likeness(tmp_path / "sofa", tmp_path / "true")[2:] == (None, None, None)


def _write(folder: Path) -> dict:
    scene, seen = scene_and_objects()
    for true in TRUTH.objects:
        about = {"id": true.asset, "category": true.category, "licence": "", "provenance": "", "checksum": "0"}
        write_json(folder / true.asset / "asset.json", Asset(box_min=(0, 0, 0), box_max=true.size, mass=1, **about))
    write_part(folder / "library.json", folder)
    for name, value in {"scene_1": scene, "objects": seen, "truth": TRUTH}.items():
        write_json(folder / f"{name}.json", value)
    write_json(folder / "scene_2.json", scene.model_copy(update={"rank": 2}))
    return {name: folder / f"{name}.json" for name in ("objects", "truth", "library")} | {
        "scenes": (folder / "scene_1.json", folder / "scene_2.json"),
        "out": folder / "scores.csv",
    }


def test_the_table_holds_all_ranks_and_meets_its_contract(tmp_path: Path) -> None:
    run(**_write(tmp_path))
    table = pd.read_csv(tmp_path / "scores.csv")
    assert len(table) == 10 and set(table["rank"]) == {1, 2} and table.l2_cm.isna().sum() == 4
    assert check_contract(["scores", str(tmp_path / "scores.csv")]) == 0


def test_rows_say_who_decided(tmp_path: Path) -> None:
    files = _write(tmp_path)
    view = Orientation(yaw=0, distance=0)
    best = Cousin(rank=1, asset="a", category="c", distance=0, votes=None, orientation=view, orientations=[view])
    by = {"decided_by": "vlm toy", "orientation_decided_by": "distance"}
    judged = ObjectCousins(id="chair_1", label="chair", cousins=[best], **by)
    write_json(tmp_path / "cousins.json", Cousins(scene="room_t", encoder="hog", objects=[judged]))
    run(**files, cousins=tmp_path / "cousins.json")
    table = pd.read_csv(tmp_path / "scores.csv", keep_default_na=False).set_index(["rank", "object"])
    assert table.loc[(2, "chair_1"), ["model_judge", "orientation_judge"]].tolist() == ["vlm toy", "distance"]
    assert table.loc[(1, "lamp_1"), "model_judge"] == ""
    assert check_contract(["scores", str(tmp_path / "scores.csv")]) == 0
    write_json(tmp_path / "cousins.json", Cousins(scene="other", encoder="hog", objects=[]))
    with refused("E-SCENE-MIXED"):
        run(**files, cousins=tmp_path / "cousins.json")


def test_files_of_different_rooms_are_refused(tmp_path: Path) -> None:
    files = _write(tmp_path)
    write_json(files["truth"], TRUTH.model_copy(update={"scene": "room_x"}))
    with refused("E-SCENE-MIXED"):
        run(**files)
    assert not files["out"].exists()


def test_a_truth_of_another_library_is_refused(tmp_path: Path) -> None:
    files = _write(tmp_path)
    other = LibraryEntry(id="sofa_0", category="sofa", archive="none.zip", doors=0, drawers=0, checksum="0")
    write_json(files["library"], Library(assets=[other]))
    with refused("E-LIBRARY-ASSET"):
        run(**files)


@pytest.mark.parametrize("name", ["scene_2", "truth"])
def test_a_category_that_the_library_does_not_give_a_model_is_refused(tmp_path: Path, name: str) -> None:
    files = _write(tmp_path)
    path = tmp_path / f"{name}.json"
    path.write_text(path.read_text().replace('"category": "cabinet"', '"category": "chair"', 1))
    with refused("E-SCENES-CATEGORY"):
        run(**files)
    assert not files["out"].exists()


def test_what_falls_is_held_or_reaches_behind_a_wall_is_not_stable() -> None:
    scene, seen = scene_and_objects()
    settled = {"fallen": ["chair_1"], "held": ["bowl_1"], "behind": ["cabinet_1"], "stable": False}
    for faults in (settled, settled | {"behind": []}):
        check = scene.plausibility.model_copy(update=faults)  # type: ignore[union-attr]
        rows = {row.object: row for row in score_scene(scene.model_copy(update={"plausibility": check}), seen, TRUTH)}
        assert (rows["chair_1"].stable, rows["bowl_1"].stable) == (False, False)
        assert rows["cabinet_1"].stable is not bool(faults["behind"])
