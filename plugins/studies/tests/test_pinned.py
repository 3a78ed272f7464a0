"""`studies pinned`: committed assets are used only with the very models that they were chosen from."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from roomkin.plugins.studies.pinned import run as pinned
from roomkin.plugins.studies.pinned_file import read_pinned, write_pinned
from roomkin.stages.config.model import load, merge_mappings, with_defaults
from roomkin.stages.contracts import InputError, TaskAssets, read_json, write_json
from roomkin.stages.contracts.library_folder import write_part
from tests.refusals import refused
from tests.unit.demo_assets import an_asset, cabinet

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A library of two cabinets, and a plan with one as the twin and one to test on."""
    folder = tmp_path_factory.mktemp("study")
    built = {name: cabinet(folder / name, handle=handle) for name, handle in (("cab_1", "bar"), ("lone_1", "knob"))}
    write_part(folder / "library.json", folder)
    known = {name: {"digest": asset.checksum, "joint": asset.joints[0].name} for name, asset in built.items()}
    twin = an_asset("cab_1", 0, role="twin", **known["cab_1"])
    test = an_asset("lone_1", role="test", **known["lone_1"])
    plan = TaskAssets(task="door", scene="room_3", object="cab_1", encoder="hog", assets=[twin], test_assets=[test])
    write_json(folder / "door.json", plan)
    return {"assets": folder / "door.json", "library": folder / "library.json"}


def test_a_file_is_taken_over_for_its_task(study: dict[str, Path], tmp_path: Path) -> None:
    pinned(**study, task="door", out=tmp_path / "assets.json")
    assert (tmp_path / "assets.json").read_bytes() == study["assets"].read_bytes()
    with refused("E-ASSETS-CHANGED"):
        pinned(**study, task="drawer", out=tmp_path / "drawer.json")
    assert not (tmp_path / "drawer.json").exists()


def test_a_file_of_fewer_draws_than_seeds_need_is_refused(study: dict[str, Path], tmp_path: Path) -> None:
    plan, file = read_json(TaskAssets, study["assets"]), tmp_path / "door.json"
    cousins = [an_asset(f"near{number}_1", 1.0, role=f"cousin_{number}") for number in range(1, 11)]
    named = {"object": "hanging_cabinet_1", "assets": [*plan.assets, *cousins], "held_out": [2, 6]}
    chance = [an_asset(f"chance{number}_1", role="random") for number in range(8)]
    write_json(file, plan.model_copy(update=named | {"random_assets": chance}))
    default = with_defaults({})

    def read(sets: list[str], **asked: Any) -> None:
        load(
            merge_mappings(
                default, {"experiment": {"targets": {"door": {"assets": str(file)}}, "training_sets": sets} | asked}
            )
        )

    read(["twin", "cousins_8", "twin_randomised"])
    read(["random_8"], draws=1)
    with refused("E-CONFIG-CLASH", f"experiment.draws: 5, but {file} has 1 for random_8. Fix: lower it"):
        read(["random_8"])
    with refused("E-CONFIG-CLASH", f"experiment.training_sets: cover_8 needs 8 assets, {file} has 0 in a draw"):
        read(["cover_8"], draws=1)
    with refused("E-CONFIG-CLASH", "random_10_randomised needs 10 assets"):
        read(["random_10_randomised"], draws=1)


def test_a_table_says_what_the_json_says(
    study: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, table = read_json(TaskAssets, study["assets"]), tmp_path / "door.csv"
    cousins = [an_asset(f"near{number}_1", number / 3, role=f"cousin_{number}") for number in (1, 2)]
    drawn = [an_asset("far_1", 1e-5, role="cover"), an_asset("wide_1", role="cover")]
    more = {"assets": [*plan.assets, *cousins], "held_out": [2, 6], "draws": 2, "cover_assets": drawn}
    write_pinned(table, plan.model_copy(update=more))
    assert read_pinned(table) == plan.model_copy(update=more)
    pinned(**study, task="door", out=tmp_path / "committed.csv")
    assert capsys.readouterr().out == f"{tmp_path / 'committed.csv'}\n"
    assert read_pinned(tmp_path / "committed.csv") == plan
    pinned(**study | {"assets": tmp_path / "committed.csv"}, task="door", out=tmp_path / "assets.json")
    assert (tmp_path / "assets.json").read_bytes() == study["assets"].read_bytes()


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("lone,", "cab,", "E-CONTRACT-BROKEN", "TaskAssets contract at lone_1: its family"),
        (",room_3,", ",room_4,", "E-CONTRACT-BROKEN", "door.csv:3: is about another experiment than line 2"),
        ("0.4 0.6", "0.4", "E-CONTRACT-BROKEN", "PinnedAsset contract at panel_size"),
    ],
)
def test_a_table_that_is_broken_is_refused(
    study: dict[str, Path], tmp_path: Path, old: str, new: str, code: str, words: str
) -> None:
    pinned(**study, task="door", out=tmp_path / "door.csv")
    head, twin, test = (tmp_path / "door.csv").read_text().splitlines()
    assert old in test
    (tmp_path / "door.csv").write_text("\n".join([head, twin, test.replace(old, new)]))
    with refused(code, words):
        read_pinned(tmp_path / "door.csv")


def test_a_changed_or_lost_model_is_refused(study: dict[str, Path], tmp_path: Path) -> None:
    plan = read_json(TaskAssets, study["assets"])
    changed = [plan.test_assets[0].model_copy(update={"digest": "c0ffee"})]
    write_json(tmp_path / "door.json", plan.model_copy(update={"test_assets": changed}))
    files = study | {"assets": tmp_path / "door.json", "out": tmp_path / "assets.json"}
    with pytest.raises(
        InputError, match=r"library.json: has another lone_1 .* than the one \(digest c0ffee\) in .*Fix"
    ):
        pinned(**files, task="door")
    write_json(tmp_path / "door.json", plan.model_copy(update={"cover_assets": [an_asset("gone_1")]}))
    with refused("E-ASSETS-CHANGED"):
        pinned(**files, task="door")


OTHER = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V4"}  # names that x86 alone knows


@pytest.mark.parametrize(("seed", "folder", "kernels"), [("0", ".", {}), ("2026", "registered", OTHER)])
def test_committed_models_are_the_same_on_other_processors(seed: str, folder: str, kernels: dict[str, str]) -> None:
    """By this machine's own kernels of linear algebra, and by the oldest."""
    files = sorted((ROOT / "config/study/assets" / folder).glob("*.csv"))
    plans = [read_pinned(file) for file in files]
    known = {item.asset: item.digest for plan in plans for item in (*plan.assets, *plan.test_assets)}
    command = [sys.executable, "-m", "roomkin.plugins.studies.tests.pinned_models", seed, *map(str, files)]
    made = subprocess.run(command, cwd=ROOT, env=os.environ | kernels, check=True, capture_output=True, text=True)
    assert dict(line.split() for line in made.stdout.splitlines()) == known


def mistakes(**changes: Any) -> str:
    default = with_defaults({})
    with pytest.raises(InputError) as error:
        load(merge_mappings(default, {"experiment": changes}))
    return str(error.value)


def test_a_target_and_its_file_agree(study: dict[str, Path]) -> None:
    assert "experiment.targets.door.assets: no file nothing.json" in mistakes(
        targets={"door": {"assets": "nothing.json"}}
    )
    row = {"door": {"assets": str(study["assets"]), "object": "hanging_cabinet_1"}}
    found = mistakes(targets=row)
    assert (
        "experiment.targets.door.object: hanging_cabinet_1 of room_3, but" in found and "about cab_1 of room_3" in found
    )
    assert "experiment.held_out: [2, 6], but" in found and "experiment.cousins: 10, but" in found
    assert "breaks the TaskAssets contract" in mistakes(targets={"door": {"assets": str(study["library"])}})
