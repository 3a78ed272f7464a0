"""Handles of models: where the source says so."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from benchmarks.open_rooms import handles, packs, publish
from roomkin.plugins.scorecard.tests.rooms import CABINET, TRUTH, write_rooms
from roomkin.plugins.scorecard.truth import as_plain, list_rooms, read_truth
from roomkin.stages.contracts import write_json
from tests.refusals import refused


def write_cupboard(root: Path, *names: str, opens: int = 2) -> packs.PackModel:
    """An OBJ, y up and front +z: a body, and a box a name, from left to right along the front."""
    boxes = [("body", trimesh.creation.box((1.0, 0.8, 0.5)))]
    for place, name in enumerate(names):
        box = trimesh.creation.box((0.02, 0.1, 0.04)).apply_translation((0.1 * place - 0.2, 0.1, 0.27))
        boxes.append((name, box))
    lines, count = list[str](), 1
    for name, box in boxes:
        lines.append(name if name.startswith("usemtl") else f"g {name}")
        lines += [f"v {x} {y} {z}" for x, y, z in box.vertices]
        lines += [f"f {a}/1 {b}/1 {c}/1" for a, b, c in box.faces + count]
        count += len(box.vertices)
    path = root / "planner/cupboard/cupboard.obj"
    path.parent.mkdir(parents=True)
    path.write_text("\n".join(["vt 0 0", *lines]))
    return packs.PackModel("planner", "cupboard", "chest", ("left",) * opens, "knob", "none", "", 2.0, root)


def test_handles_are_what_an_obj_calls_so(tmp_path: Path) -> None:
    one, other = handles.find_handles(write_cupboard(tmp_path, "left_Handle", "trim", "door_handle.002"))
    assert sorted([one.panel, other.panel]) == [0, 1]
    # Of a box of 1.08 x 2 x 1.6 m: `scale` is 2, front +x, left +y (the viewer's right), its own middle at 0.
    left, right = sorted([one, other], key=lambda handle: handle.position[1])
    assert left.position == pytest.approx((0.5, -0.4, 0.2)) and right.position == pytest.approx((0.5, 0.0, 0.2))
    assert left.size == pytest.approx((0.08, 0.04, 0.2))


@pytest.mark.parametrize(
    ("names", "panels"),
    [
        (["usemtl Handles", "more"], [0, 1]),  # a material goes on over groups
        (["on_rail_2_handle1", "on_rail_1_handle", "on_rail_2_handle2"], [0, 1, 1]),  # a drawer with two
        (["handle1", "handle2", "handle3"], []),  # which of them are of one drawer is not said
        (["handle1"], []),
        (["knob1", "knob2"], []),
    ],
)
def test_handles_are_known_where_every_panel_has_its_own(tmp_path: Path, names: list[str], panels: list[int]) -> None:
    found = handles.find_handles(write_cupboard(tmp_path, *names))
    assert sorted(handle.panel for handle in found) == panels


def test_pieces_that_touch_are_one_handle() -> None:
    corners = np.array([[[0, 0, 0], [1, 1, 1]], [[1.005, 0, 0], [2, 1, 1]], [[2.05, 0, 0], [3, 1, 1]]])
    boxes = handles.join_boxes(corners)
    assert sorted((low[0], high[0]) for low, high in boxes) == [(0, 2), (2.05, 3)]


def test_handles_of_a_mujoco_file_are_geoms_meshes_or_sites(tmp_path: Path) -> None:
    path = tmp_path / packs.MJCF["franka"]
    path.parent.mkdir(parents=True)
    none = 'contype="0" conaffinity="0"'
    path.write_text(
        f'<mujoco><worldbody><body name="other"><site name="handle"/></body><body name="oven" euler="0 0 90" '
        f'pos="3 4 5"><geom type="box" size="1 2 3" {none}/><geom name="door_handle" type="box" size=".1 .1 .1" '
        f'pos=".5 0 1"/><body><site name="Handle_site" pos=".9 1 2"/></body></body></worldbody></mujoco>'
    )
    model = packs.PackModel("franka", "oven", "oven", ("bottom", "slide"), "bar", "none", "", 0.5, tmp_path)
    geom, site = sorted(handles.find_handles(model), key=lambda handle: handle.position[2])
    assert geom.position == pytest.approx((0.25, 0, 0.5)) and geom.size == pytest.approx((0.1, 0.1, 0.1))
    assert site.position == pytest.approx((0.45, 0.5, 1.0)) and site.size == (0, 0, 0)


def test_truths_know_the_handles_of_their_models_that_stand_beside(tmp_path: Path) -> None:
    model = write_cupboard(tmp_path / "packs", "left_handle", "right_handle")
    data = write_rooms(tmp_path / "rooms")
    (folder,) = list_rooms(data, "toy")
    before = (folder / "truth.json").read_bytes()
    publish.write_handles(data / "toy/handles.json", [model])
    text = (data / "toy/handles.json").read_text().replace(model.id, CABINET.model)
    (data / "toy/handles.json").write_text(text)
    (cabinet,) = [thing for thing in read_truth(folder / "truth.json").things if thing.handles]
    assert cabinet.model == CABINET.model and len(cabinet.handles) == 2
    write_json(folder / "truth.json", as_plain(TRUTH))
    assert (folder / "truth.json").read_bytes() == before  # by room it is not told again
    (data / "toy/handles.json").write_text("[]")
    with refused("E-CONTRACT-BROKEN"):
        read_truth(folder / "truth.json")
