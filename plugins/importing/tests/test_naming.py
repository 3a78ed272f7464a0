"""Names and categories of models: in any script, by the folder, the file or what the model calls itself."""

from pathlib import Path

import pytest
import trimesh

from roomkin.plugins.importing.discover import Given, discover
from roomkin.plugins.importing.import_ import run
from roomkin.plugins.importing.sandbox import snake_case
from roomkin.plugins.importing.tests.test_fronts import box

LINK = f'<link name="a">{box("0.5 0.5 0.8")}</link>'


@pytest.mark.parametrize(
    ("path", "own", "category", "name"),
    [
        ("Stühle/Modell für Küche.urdf", "", "chair", "Modell für Küche"),
        ("столы/1.urdf", "", "table", "1"),
        ("椅子/a.urdf", "", "chair", "a"),
        ("Küchenstuhl.urdf", "", "chair", "Küchenstuhl"),
        ("kitchen_description/urdf/base_cabinet.urdf", "", "bottom_cabinet", "base_cabinet"),
        ("kitchen_description/urdf/robot.urdf", "base_cabinet", "bottom_cabinet", "kitchen_description"),
        ("kitchen_description/model.urdf", "fridge", "fridge", "model"),
        ("chair_description/urdf/table.urdf", "table", "chair", "table"),
        ("model.urdf", "Esstisch", "table", "model"),
        ("kitchen_description/urdf/robot.urdf", "thing", "kitchen", "kitchen_description"),
        ("坩堝/a.urdf", "", "坩堝", "a"),
    ],
)
def test_what_a_model_is_taken_for(tmp_path: Path, path: str, own: str, category: str, name: str) -> None:
    file = tmp_path / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f'<?xml version="1.0"?><robot name="{own}">{LINK}</robot>')
    (tmp_path / "other").mkdir()
    assert discover(tmp_path, [".urdf"]) == [Given(file, tmp_path, category, name)]


def test_what_mjcf_calls_itself(tmp_path: Path) -> None:
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack/scene.xml").write_text('<mujoco model="base_cabinet"/>')
    assert [one.category for one in discover(tmp_path, [".xml"])] == ["bottom_cabinet"]


def test_letters_of_any_script_stay_readable_and_distinct() -> None:
    told = {
        "Modell für Küche": "modell_fur_kuche", "Größe 2": "grosse_2", "Łóżka": "lozka", "щётка": "shchetka",
        "κατσαρόλα": "katsarola", "ナベ": "nabe", "기타": "gita", "椅子": "u6905u5b50", "桌子": "u684cu5b50",
        "chair 1": "chair_1",
    }  # fmt: skip
    assert {name: snake_case(name) for name in told} == told
    others = ["कड़ाही", "กระทะ", "קערה", "قدر"]
    assert len({snake_case(name) for name in others}) == len(others)
    assert all(snake_case(name).isascii() and snake_case(name) != "model" for name in others)


def test_a_category_that_nobody_knows_is_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for folder in ("щётки", "桌腿", "стулья"):
        (tmp_path / "theirs" / folder).mkdir(parents=True)
        size = (0.5, 0.45, 0.9) if folder == "стулья" else (0.1, 0.2, 0.3 if folder == "桌腿" else 0.4)
        trimesh.creation.box(size).export(tmp_path / "theirs" / folder / "a.glb")
    run(tmp_path / "theirs", out=tmp_path / "mine")
    said = capsys.readouterr().out
    for name in ("shchetki", "u684cu817f"):
        assert f"no category of ours is called '{name}'" in said and f"pack.yaml: categories: {{{name}: chair}}" in said
    assert said.count("no category of ours") == 2
    pack = tmp_path / "mine/pack.yaml"
    text = pack.read_text()
    pack.write_text(text.replace("shchetki: shchetki  # none of ours", "shchetki: vase"))
    (tmp_path / "theirs/桌腿/asset.json").write_text('{"category": "table_leg"}')
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert "no category of ours" not in capsys.readouterr().out
