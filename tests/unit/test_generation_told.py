"""Generation with corrections: models that a person chose, what carries what, nudges."""

from pathlib import Path

import pytest

from roomkin.stages.config.code import record_provenance
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import GeneratedScene, InputError, Objects, read_json, write_json
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.hand import Correction, Corrections
from roomkin.stages.generation.generate import run
from roomkin.stages.generation.inputs import read_inputs
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.stacking import apply_stated
from tests.unit.generation_scenes import Built, build, thing
from tests.unit.test_generation_run import scene  # noqa: F401

CABINET, MUG = 1, 2


def _built(scene: dict[str, Path], folder: Path, rank: int, *told: Correction, **supports: str) -> Built:  # noqa: F811
    """The scene of a rank with corrections; `supports`: by id, as extraction hands on what a person says."""
    objects = read_json(Objects, scene["objects"])
    for item in objects.objects:
        item.support = supports.get(item.id)
    write_json(folder / "objects.json", objects)
    for name in ("clouds.npz", "masks.png"):
        (folder / name).write_bytes(scene["objects"].with_name(name).read_bytes())
    write_json(folder / "corrections.json", Corrections(objects=list(told)))
    inputs = read_inputs(scene["cousins"], folder / "objects.json", scene["library"], (folder / "corrections.json",))
    return build(inputs, rank, GenerationConfig())


def _of(built: Built, name: str) -> Placed:
    return next(item for item in built.items if item.id == name)


def test_a_chosen_model_comes_before_those_that_were_ranked(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    told = Correction(mask=CABINET, model="bottom_cabinet_1")
    first, second = (_of(_built(scene, tmp_path, rank, told), "cabinet_1") for rank in (1, 2))
    assert (first.asset.id, first.cousin, first.steps[0]) == ("bottom_cabinet_1", 2, "chosen by a person")
    assert first.chosen and not second.chosen
    assert (second.asset.id, second.cousin) == ("bottom_cabinet_0", 1)
    pinned = _built(scene, tmp_path, 2, told.model_copy(update={"pinned": True}))
    assert _of(pinned, "cabinet_1").asset.id == "bottom_cabinet_1"


def test_any_model_of_the_library_may_be_chosen_and_others_are_said(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    built = _built(scene, tmp_path, 1, Correction(mask=MUG, model="mug_1"))
    assert (_of(built, "mug_1").asset.id, _of(built, "mug_1").cousin) == ("mug_1", None)
    assert _built(scene, tmp_path, 1, Correction(mask=MUG, model="mug_9")).failed["mug_1"] == (
        "asset 'mug_9' is not in the library"
    )


def test_banned_models_stand_nowhere(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    ban = Correction(mask=CABINET, banned=["bottom_cabinet_0"])
    assert _of(_built(scene, tmp_path, 1, ban), "cabinet_1").asset.id == "bottom_cabinet_1"
    assert _built(scene, tmp_path, 1, Correction(mask=MUG, banned=["mug_0"])).failed["mug_1"] == (
        "all of its cousins are banned"
    )


def test_what_is_like_another_has_its_model_at_every_rank(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    for rank in (1, 2):
        built = _built(scene, tmp_path, rank, Correction(mask=CABINET, like=MUG))  # the one that comes later, too
        assert _of(built, "cabinet_1").asset.id == _of(built, "mug_1").asset.id == "mug_0"


def test_a_nudge_moves_what_stands_on_it_too(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    before, after = (
        {item.id: item for item in _built(scene, tmp_path, 1, *told).items}
        for told in ((), (Correction(mask=CABINET, nudge=(-0.1, 0.05)),))
    )
    assert before["mug_1"].support == "cabinet_1"
    for name in ("cabinet_1", "mug_1"):
        assert after[name].center - before[name].center == pytest.approx([-0.1, 0.05, 0], abs=1e-6)
        assert after[name].steps[-1].startswith("moved by a person: moved 11.2 cm")


def test_a_place_that_a_person_said_is_not_doubted(
    scene: dict[str, Path],  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        "roomkin.stages.generation.scene_file.measure_place_sureness", lambda spread: 0.1 if spread else 1.0
    )
    unsure = DoubtKind.PLACE_UNSURE.of(share=10)
    before, after = (
        {item.id for item in _built(scene, tmp_path, 1, *told).items if unsure in item.doubts}
        for told in ((), (Correction(mask=CABINET, nudge=(-0.1, 0.05)),))
    )
    assert before - after == {"cabinet_1"} and "mug_1" in after


def test_what_a_person_says_carries_it_does(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    mug = _of(_built(scene, tmp_path, 1, mug_1="floor"), "mug_1")
    assert mug.support == "floor" and mug.box.bottom == pytest.approx(0, abs=1e-6)


def test_nothing_carries_itself_by_what_was_told() -> None:
    heights = {"low": 0.1, "mid": 0.3, "top": 0.5}
    items = [thing(name, (0, 0, height), (0.4, 0.4, 0.2)) for name, height in heights.items()]
    found = {"low": "floor", "mid": "low", "top": "mid"}
    ordered, supports = apply_stated(items, found, {"low": "top"})
    assert supports == {"low": "top", "mid": "floor", "top": "mid"}
    assert [item.id for item in ordered] == ["mid", "top", "low"]
    assert apply_stated(items, found, {"low": "gone"})[1] == found  # what is not placed carries nothing


def test_a_scene_says_that_corrections_were_among_what_it_was_made_of(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    told = tmp_path / "corrections.json"
    write_json(told, Corrections(objects=[Correction(mask=MUG, model="mug_1")]))
    options = GenerationConfig(ranks=1, sizes="measured")
    run(**scene, variant="v", out=tmp_path, corrections=(told,), options=options.model_dump_json())
    made = read_json(GeneratedScene, tmp_path / "scene_1.json").made
    assert made == record_provenance("roomkin.stages.generation.generate", options, [*scene.values(), told])


def test_a_broken_file_is_named(scene: dict[str, Path], tmp_path: Path) -> None:  # noqa: F811
    (tmp_path / "corrections.json").write_text('{"version": 1, "objects": [{"mask": 0}]}')
    with pytest.raises(InputError, match=r"corrections\.json.*mask"):
        read_inputs(scene["cousins"], scene["objects"], scene["library"], (tmp_path / "corrections.json",))
