"""Options of the stages that make no sense: one line with the key, before anything is read or written."""

import importlib
import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import generate
from roomkin.plugins.scenes.recipe import ScenesConfig
from roomkin.stages.cli import main
from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.config.evaluation import EvaluationConfig, TablesConfig
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.config.packages import home_of
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import InputError, read_options
from roomkin.stages.contracts.library import Recipe
from roomkin.stages.contracts.policy_config import PolicyConfig, TaskConfig
from tests.packages import needs
from tests.unit.contract_files import contents, write_files

SECTIONS = [AssetsConfig, ScenesConfig, ExtractionConfig, MatchingConfig, GenerationConfig, DemonstrationsConfig,
            TaskConfig, PolicyConfig, EvaluationConfig, TablesConfig]  # fmt: skip


@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize("text", ["{", "{]}", '{"no_such_key": 1}', '{"a": {"b": ', "none.json"])
def test_options_that_are_none(section: Any, text: str) -> None:
    with pytest.raises(InputError) as error:
        read_options(section, text)
    assert "\n" not in str(error.value) and str(error.value).startswith(("--options", "none.json"))


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        (AssetsConfig, "counts", {"mug": -1}), (AssetsConfig, "n_snap", 0), (AssetsConfig, "image_size", 10**6),
        (AssetsConfig, "folders", "models"), (AssetsConfig, "shards", 0),
        (ScenesConfig, "width", 0), (ScenesConfig, "supersampling", 99), (ScenesConfig, "height", "high"),
        (ExtractionConfig, "crop", 1.5), (ExtractionConfig, "crop", 0), (ExtractionConfig, "noise.scale", float("inf")),
        (ExtractionConfig, "depth_noise", "much"), (ExtractionConfig, "trim", 0.5),
        (MatchingConfig, "hog.grid", 7), (MatchingConfig, "hog.image_size", 0), (MatchingConfig, "k_cousins", 0),
        (MatchingConfig, "exclude_worst", 2), (MatchingConfig, "count_threshold", -1), (MatchingConfig, "k_cat", 0.5),
        (GenerationConfig, "ranks", 0), (GenerationConfig, "settle_seconds", float("nan")),
        (GenerationConfig, "trim", 0.5), (GenerationConfig, "max_stretch", 0),
        (DemonstrationsConfig, "goal_margin", 2), (DemonstrationsConfig, "recovery", 2),
        (DemonstrationsConfig, "max_attempts_factor", float("inf")), (DemonstrationsConfig, "noise", -1),
        (TaskConfig, "control_frequency", 0), (TaskConfig, "success_fraction", 1.0), (TaskConfig, "points", 0),
        (TaskConfig, "camera_eye", [1, 2]), (TaskConfig, "camera_fov", 3.2), (TaskConfig, "scale_range", [1.1, 0.9]),
        (PolicyConfig, "horizon", 0), (PolicyConfig, "steps", 0), (PolicyConfig, "learning_rate", float("nan")),
        (PolicyConfig, "batch_size", 2.5), (PolicyConfig, "jitter", -1), (PolicyConfig, "points", 1),
        (PolicyConfig, "schedule", "never"), (PolicyConfig, "num_checkpoints", -1),
        (EvaluationConfig, "rollouts", 0), (EvaluationConfig, "checkpoint", "worst"),
        (EvaluationConfig, "split", "train"), (EvaluationConfig, "test_assets", "twin"),
        (EvaluationConfig, "camera_error", [-1, 0]), (EvaluationConfig, "robot_init_noise", [-1, 0]),
        (TablesConfig, "bootstrap_samples", 1), (TablesConfig, "scenes", {"r": 9}),
    ],
)  # fmt: skip
def test_options_out_of_bounds(tmp_path: Path, section: Any, key: str, value: Any) -> None:
    for part in reversed(key.split(".")):
        value = {part: value}
    (tmp_path / "options.json").write_text(json.dumps(value))
    for text in (json.dumps(value), str(tmp_path / "options.json")):
        with pytest.raises(InputError) as error:
            read_options(section, text)
        assert key.split(".")[-1] in str(error.value) and "\n" not in str(error.value)


# through the command line: exit code 1, one line, nothing written


@pytest.fixture(scope="module")
def valid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_files(tmp_path_factory.mktemp("valid"))


COMMANDS = {
    "extraction extract": "--input input --scene room --out out/objects.json",
    "pictures objects": "--objects extraction/objects.json --image input/rgb.png --out out/overview.png",
    "matching features": "--snapshots snapshots/shard_0.h5 --out out/shard_0.npy",
    "matching match": "--objects extraction/objects.json --image input/rgb.png --library library/library.json "
    "--features features/shard_0.npy --out out/cousins.json",
    "experiment select": "--cousins matching/cousins.json --scene-file generation/scene_1.json --object cabinet_1 "
    "--task door --library library/library.json --distances matching/distances.json --out out/assets.json",
    "evaluation score": "--scenes generation/scene_1.json --objects extraction/objects.json --truth truth.json "
    "--library library/library.json --out out/scores.csv",
    "training train": "--episodes demonstrations/episodes.h5 --per-store 2 --out out/policy",
    "tables scenes": "--scores evaluation/scores.csv --out out",
    "tables policies": "--rollouts evaluation/rollouts.csv --out out",
}


def no_json(path: Path) -> None:
    path.write_text("{")


def older(path: Path) -> None:
    path.write_text(path.read_text().replace('"version": 1', '"version": 0'))


def truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


@pytest.mark.parametrize(
    ("command", "file", "how"),
    [
        ("extraction extract", "input/camera.json", no_json), ("extraction extract", "input/annotations.json", older),
        ("extraction extract", "input/rgb.png", truncated), ("extraction extract", "input/depth.npz", truncated),
        ("extraction extract", "input/masks.png", truncated),
        pytest.param("pictures objects", "input/rgb.png", truncated, marks=needs("pictures")),
        pytest.param("pictures objects", "extraction/objects.json", older, marks=needs("pictures")),
        pytest.param("pictures objects", "extraction/masks.png", truncated, marks=needs("pictures")),
        ("matching features", "snapshots/shard_0.json", no_json),
        ("matching features", "snapshots/shard_0.h5", truncated),
        ("matching match", "extraction/objects.json", older), ("matching match", "library/library.json", no_json),
        ("matching match", "features/shard_0.npy", truncated), ("matching match", "features/shard_0.json", older),
        ("experiment select", "matching/cousins.json", no_json),
        ("experiment select", "matching/distances.json", older),
        ("experiment select", "generation/scene_1.json", older), ("experiment select", "library/library.json", older),
        ("evaluation score", "truth.json", no_json), ("evaluation score", "generation/scene_1.json", no_json),
        ("evaluation score", "extraction/objects.json", no_json),
        ("evaluation score", "library/library.json", no_json),
        ("training train", "demonstrations/episodes.h5", truncated),
        ("tables scenes", "evaluation/scores.csv", truncated),
        ("tables policies", "evaluation/rollouts.csv", truncated),
    ],
)  # fmt: skip
def test_a_stage_ends_with_one_line(
    valid: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    file: str,
    how: Callable[[Path], None],
) -> None:
    shutil.copytree(valid, tmp_path / "run")
    monkeypatch.chdir(tmp_path / "run")
    how(Path(file))
    before = contents(tmp_path)
    stage, name = command.split()
    monkeypatch.setattr(sys, "argv", ["stages", name, *COMMANDS[command].split()])
    if command == "matching match":
        digest_of_the_store(monkeypatch)
    with pytest.raises(SystemExit) as end:
        main(home_of(stage), {name: ""})
    error = capsys.readouterr().err
    assert end.value.code == 1
    assert error.startswith("error: ") and error.count("\n") == 1 and Path(file).name in error, error
    assert contents(tmp_path) == before


def digest_of_the_store(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let matching believe that the made-up store is its encoder's, so that it looks at the rows."""
    monkeypatch.setattr(importlib.import_module("roomkin.stages.matching.match"), "settings_digest", lambda *_: "abc")


# recipes: read from asset.json, made again at another size


@pytest.mark.parametrize(
    "changes",
    [
        {"size": None}, {"size": "large"}, {"size": [1.0, 1.0]}, {"size": [0.0, 1.0, 1.0]}, {"size": [-1.0, 1.0, 1.0]},
        {"size": [400.0, 1.0, 1.0]}, {"size": [float("nan"), 1.0, 1.0]}, {"layout": None}, {"layout": []},
        {"layout": [["trapdoor"]]}, {"handle": "claw"}, {"board": "thick"}, {"board": -1.0}, {"no_such_key": 1},
        {"body_colour": [2.0]}, {"shelves": "two"},
    ],
    ids=str,
)  # fmt: skip
def test_a_recipe_that_makes_nothing(changes: dict[str, Any]) -> None:
    recipe = sample("bottom_cabinet", 0, 0)
    parameters = {name: value for name, value in (recipe.parameters | changes).items() if value is not None}
    broken = Recipe.model_construct(generator=recipe.generator, parameters=parameters)
    with pytest.raises(InputError, match="recipe") as error:
        generate(broken)
    assert "\n" not in str(error.value)


def test_the_generators_refuse_what_lacks_a_key() -> None:
    for category in ("mug", "sofa", "table_lamp", "bookshelf", "picture"):
        recipe = sample(category, 0, 0)
        for name in recipe.parameters:
            left = {key: value for key, value in recipe.parameters.items() if key != name}
            try:
                model = generate(Recipe(generator=recipe.generator, parameters=left))
            except InputError as error:
                assert "recipe" in str(error) and "\n" not in str(error)
            else:  # some have a default
                assert np.isfinite(model.base[0].mesh.vertices).all()
