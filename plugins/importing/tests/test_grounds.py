"""A mesh file with its ground: the doubt names it, asset.json leaves it out; what lies on its side is doubted."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh import Scene, Trimesh

from roomkin.plugins.importing.import_ import run
from roomkin.plugins.importing.imports import Notes
from roomkin.plugins.importing.single_body import find_ground, read_mesh

LEGS = [(x, y) for x in (-0.55, 0.55) for y in (-0.3, 0.3)]
Y_UP = trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0])
TABLE, CHAIR = (1.2, 0.7, 0.75), (0.45, 0.45, 0.9)


def box(size: tuple[float, float, float], x: float = 0, y: float = 0, bottom: float = 0) -> Trimesh:
    """A box, z up."""
    place = trimesh.transformations.translation_matrix([x, y, bottom + size[2] / 2])
    return trimesh.creation.box(size, place)


def table() -> list[Trimesh]:
    return [box((1.2, 0.7, 0.03), bottom=0.72), *(box((0.05, 0.05, 0.72), x, y) for x, y in LEGS)]


def chair() -> list[Trimesh]:
    legs = [box((0.04, 0.04, 0.45), x, y) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    return [*legs, box((0.45, 0.45, 0.04), bottom=0.43), box((0.04, 0.45, 0.45), x=-0.205, bottom=0.45)]


GROUNDS = {
    "square": box((4, 4, 0.002), bottom=-0.002),
    "disc": trimesh.creation.cylinder(radius=1.5, height=0.01).apply_translation([0, 0, -0.005]),
    "slab": box((2.5, 2.5, 0.12), bottom=-0.12),
    "sheet": Trimesh([[-3, -2, 0], [3, -2, 0], [3, 2, 0], [-3, 2, 0]], [[0, 1, 2], [0, 2, 3]]),
}


def write(path: Path, things: list[Trimesh], ground: Trimesh | None, up: np.ndarray = Y_UP) -> Path:
    """A GLB: a root, of which things and ground are nodes; the ground's node may hold its mesh below it."""
    scene = Scene()
    scene.graph.update("root", "world", matrix=up)
    for number, mesh in enumerate(things):
        scene.add_geometry(mesh, node_name=f"part_{number}", parent_node_name="root")
    if ground is not None:
        scene.graph.update("Ground", "root")
        scene.add_geometry(ground, node_name="plane", geom_name="PlaneMesh", parent_node_name="Ground")
    path.parent.mkdir(parents=True)
    scene.export(path)
    return path


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize(("category", "things", "size"), [("table", table(), TABLE), ("chair", chair(), CHAIR)])
def test_a_ground_is_named_and_left_out(
    tmp_path: Path,
    category: str,
    things: list[Trimesh],
    size: tuple[float, ...],
    ground: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write(tmp_path / f"theirs/{category}/a.glb", things, GROUNDS[ground])
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    assert 'Leave out its ground, \'plane\'? asset.json: "without": ["plane"]' in said
    notes = tmp_path / f"mine/{category}/a/asset.json"
    for name in ("plane", "PlaneMesh", "Ground"):  # the node, its mesh, or a node above
        notes.write_text(json.dumps({**json.loads(notes.read_text()), "without": [name]}))
        run(tmp_path / "theirs", out=tmp_path / "mine")
        said = capsys.readouterr().out
        extents = [float(word) for word in re.findall(r"([\d.]+) (?:cm wide|deep|high)", said)]
        assert sorted(extents) == pytest.approx(sorted(100 * extent for extent in size), abs=1)
        assert f"left out, as asset.json says: {name}" in said and "usual are" not in said


def test_what_stands_beside_the_source_counts_too_and_names_must_be_right(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "theirs/chair/a/a.glb", chair(), GROUNDS["sheet"])
    write(tmp_path / "theirs/chair/b/b.glb", [box(CHAIR)], None)
    (tmp_path / "theirs/chair/a/asset.json").write_text('{"without": ["plane"]}')
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert "usual are" not in capsys.readouterr().out
    for without, why in (
        ("flor", "has no node 'flor', which asset.json leaves out. Fix: name its nodes, Ground"),
        ("root", "not leave out"),
    ):
        (tmp_path / "theirs/chair/a/asset.json").write_text(json.dumps({"without": [without]}))
        run(tmp_path / "theirs", out=tmp_path / "mine")
        assert why in capsys.readouterr().out


def test_what_is_no_ground(tmp_path: Path) -> None:
    cases = {
        "board": [box((1.2, 0.7, 0.03), bottom=0.72), box((0.6, 0.6, 0.72))],  # wide and flat, but above
        "plinth": [box((1, 1, 0.3)), box((0.3, 0.3, 0.5), bottom=0.3)],  # wide and low, but thick
        "base": [box((0.4, 0.4, 0.02)), box((0.35, 0.35, 1.5), bottom=0.02)],  # flat and lowest, but as wide
        "alone": [box((4, 4, 0.002))],
    }
    for name, things in cases.items():
        assert find_ground(read_mesh(write(tmp_path / name / "a.glb", things, None), tmp_path), 1) == "", name
    assert find_ground(read_mesh(write(tmp_path / "a/a.glb", chair(), GROUNDS["disc"]), tmp_path), 1) == "plane"


def test_what_lies_on_its_side_is_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path / "theirs/shelf_unit/a.glb", table(), None, np.eye(4))
    write(tmp_path / "upright/shelf_unit/a.glb", table(), None)
    run(tmp_path / "theirs", out=tmp_path / "mine")
    line = "  ? up +y as such files have it, though its foot would have +z: does it lie? (asset.json: up)"
    assert line in capsys.readouterr().out
    run(tmp_path / "upright", out=tmp_path / "others")
    assert "though" not in capsys.readouterr().out


def test_a_new_key_makes_no_proposal_a_persons() -> None:
    assert Notes(category="chair").add_checksum().guess == "1df8ce485062", "as 3.0.0 wrote it, which knew no `without`"
    assert Notes(category="chair").add_checksum().model_copy(update={"without": ("plane",)}).by_hand
