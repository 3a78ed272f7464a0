"""`studies choose`: which models to train on, what is told of them, and what is refused."""

from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from plugins.studies.choice import Choice
from plugins.studies.choice_report import report
from plugins.studies.choose import by_rule, choice_of
from plugins.studies.choose import run as choose
from stages.contracts import read_json, write_json
from stages.contracts.cousins import Distances
from stages.contracts.library_folder import write_part
from tests.refusals import refused
from tests.unit.demo_assets import an_asset, cabinet

# Doors of 0.3 to 0.6 m with the handle at two heights, one that hangs left, and a drawer.
MODELS: dict[str, dict[str, Any]] = {
    "a": {"size": [0.4, 0.3, 0.7]},
    "b": {"size": [0.4, 0.35, 0.7], "handle_at": 0.7},
    "c": {"size": [0.4, 0.6, 0.7]},
    "d": {"size": [0.4, 0.6, 0.7], "handle_at": 0.7},
    "left": {"hinge": -1},
    "drawer": {"layout": [["drawer"]]},
}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("library")
    for name, changes in MODELS.items():
        cabinet(folder / name, **changes)
    write_part(folder / "library.json", folder)
    return folder / "library.json"


def chosen(library: Path, out: Path, **flags: Any) -> Choice:
    choose(library=library, task="door", out=out, **flags)
    return read_json(Choice, out / "choice.json")


def test_it_tells_the_models_and_what_they_cover(
    library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    choice = chosen(library, tmp_path, count=2)
    said = capsys.readouterr().out
    names = [model.asset for model in choice.models]
    assert len(set(names)) == 2 and set(names) < set("abcd"), "doors that hang right, as most do"
    assert (choice.usable, choice.families, choice.rule, choice.like) == (4, 4, "chance", None)
    assert all(model.size[1] == MODELS[model.asset]["size"][1] for model in choice.models), "at their own size"
    assert 0.5 <= choice.within_1 <= choice.within_2 <= 1 and choice.forecast is not None
    assert said.startswith(
        "door: 2 of 4 models in 4 families (hinge right), by chance, seed 0\n  why: at eleven of twelve objects"
    )
    for what in (*names, "shows: fronts", "covers: ", "a set of 2 picked for that alone covers", "expects: "):
        assert what in said
    with Image.open(tmp_path / "choice.png") as picture:
        assert picture.format == "PNG" and picture.width > 400


def test_the_same_seed_gives_the_same_bytes(library: Path, tmp_path: Path) -> None:
    for out in ("one", "two"):
        chosen(library, tmp_path / out, count=3, seed=5)
    for name in ("choice.json", "choice.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_like_gives_the_box_and_the_side_and_its_family_is_left_out(library: Path, tmp_path: Path) -> None:
    choice = chosen(library, tmp_path, count=3, like="c")
    assert {model.asset for model in choice.models} == {"a", "b", "d"}
    assert len({model.size for model in choice.models}) == 1 and choice.models[0].size[1] == 0.6
    assert choice.forecast is None, "there is no other family"
    boxed = chosen(library, tmp_path, count=3, like="c", box=(0.4, 1.2, 0.7))
    assert boxed.models[0].panel_size[0] == pytest.approx(2 * choice.models[0].panel_size[0], rel=0.01)
    with refused("E-CHOOSE-COUNT", "0 families with a door"):
        choose(library=library, task="door", count=1, like="left")


def test_rules_draw_families_by_the_seed_and_the_nearest_are_nearest() -> None:
    pool = [an_asset(f"f{family}_{member}", 10 * member + family) for family in range(9) for member in range(3)]
    draws = [[asset.asset for asset in by_rule("chance", pool, 8, seed)] for seed in (0, 0, 1)]
    assert draws[0] == draws[1] != draws[2]
    assert all(len({name.split("_")[0] for name in draw}) == 8 for draw in draws)
    wide = [asset.model_copy(update={"panel_size": (0.2 + asset.distance / 20, 0.5)}) for asset in pool]
    spread = [by_rule("cover", wide, 8, seed) for seed in (0, 0, 1)]
    assert spread[0] == spread[1] != spread[2] and len({asset.family for asset in spread[0]}) == 8
    assert [asset.asset for asset in by_rule("nearest", pool, 3, 0)] == ["f0_0", "f1_0", "f2_0"]


def test_what_no_set_covers_and_what_is_alone_is_told() -> None:
    pool = [an_asset(name, panel_size=(width, 0.5)) for name, width in (("a", 0.2), ("b", 0.4), ("c", 0.8), ("d", 0.9))]
    choice = choice_of(pool, pool[:1], task="door", rule="chance", seed=0, like=None, box=None)
    assert (choice.within_1, choice.greedy_within_1, choice.most_within_1) == (0.25, 0.5, 0.5)
    said = "\n".join(report(choice, pool))
    assert "a set of 1 picked for that alone covers 50 % within 1, no set more than 50 %" in said
    assert "alone: 2 models are within 1 of none of another family: a, b" in said
    assert "shows: fronts 20 to 20 (library: 20 to 90) cm wide" in said
    own = choice_of(pool, pool[:1], task="put_away_bowl", rule="chance", seed=0, like=None, box=None)
    assert own.forecast is None and "expects" not in "\n".join(report(own, pool)), "no study tells of this task"


def test_the_nearest_are_those_of_the_file_of_distances(library: Path, tmp_path: Path) -> None:
    far = Distances(scene="r", object="o", encoder="hog", assets=list("abcd"), distances={"c": [3, 1, 0, 2]})
    write_json(tmp_path / "o.json", far)
    nearest: dict[str, Any] = {"rule": "nearest", "distances": tmp_path / "o.json"}
    choice = chosen(library, tmp_path, count=2, like="c", **nearest)
    assert [model.asset for model in choice.models] == ["b", "d"]
    with refused("E-CHOOSE-NEAREST", "no distances from a", "there are: c"):
        choose(library=library, task="door", count=2, like="a", **nearest)
    with refused("E-CHOOSE-NEAREST", "--like by --distances"):
        choose(library=library, task="door", count=2, rule="nearest")


@pytest.mark.parametrize(
    ("code", "words", "flags"),
    [
        ("E-PLUGIN-UNKNOWN", "dor", {"task": "dor"}),
        ("E-CHOOSE-COUNT", "4 families with a door", {"count": 5}),
        ("E-CHOOSE-COUNT", "0 models", {"count": 0}),
        ("E-CHOOSE-BOX", "metres", {"box": (0.5, 0.0, 1.0)}),
        ("E-CHOOSE-BOX", "metres", {"box": (500.0, 400.0, 900.0)}),
        ("E-LIBRARY-ASSET", "'draw'", {"like": "draw"}),
        ("E-TASK-JOINT", "no door", {"like": "drawer"}),
    ],
)
def test_what_cannot_be_chosen_is_refused(library: Path, code: str, words: str, flags: dict[str, Any]) -> None:
    with refused(code, words):
        choose(library=library, **{"task": "door", "count": 2} | flags)
