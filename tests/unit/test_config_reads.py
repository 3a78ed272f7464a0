"""What runs again when a key of the config changes: the options of every command hold what it reads and no more."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import BaseModel

from roomkin.stages.config.matching import MatchingConfig, matching_model
from roomkin.stages.config.model import complete, load, merge_mappings, read_files, with_defaults
from roomkin.stages.config.packages import find_packages, home_of
from roomkin.stages.config.reads import READS, options_of, section_name, stores
from roomkin.stages.config.weights import DINOV2, is_there
from tests.commands import list_rule_files
from tests.packages import needs

ROOT = Path(__file__).resolve().parents[2]
LISTED = {  # keys that do not simply run the one command of their section again
    "assets.counts": {"library"},
    "assets.variations": {"library"},
    "assets.folders": set(),  # parameters of a shard's own
    "assets.own_only": set(),  # the counts are none then
    "assets.only": set(),  # the counts are fewer then
    "assets.importers": {"own"},
    "assets.shards": set(),  # the number of jobs is a parameter of its own
    "matching.encoder": {"features", "match", "distances", "policies", "report"},  # tables name it
    "matching.dimensions": {"features", "match", "distances"},
    "matching.text_encoder": {"shards", "match"},
    "matching.k_cat": {"shards", "match"},
    "matching.count_threshold": {"shards", "match"},
    "matching.least_candidates": {"shards", "match"},
    "matching.search": {"match", "distances"},
    "matching.exclude_worst": {"match", "distances"},
    "matching.hog.image_size": {"features", "match", "distances"},
    "matching.hog.grid": {"features", "match", "distances"},
    "matching.hog": {"match", "distances"},  # weights: nothing is encoded anew
    "matching.dinov2": set(),
    "matching.clip": set(),
    "geometry": {"match"},
    "vlm": set(),
    "matching.kwargs": set(),
    "perception.captions": {"see"},
    "perception.by": set(),  # it chooses rules
    **{f"perception.{key}": set() for key in ("kwargs", "mounting", "labels")},
    **{f"perception.{key}": set() for key in ("detector", "segmenter", "box_threshold")},  # of `grounding` alone
    "evaluation.selection_rollouts": {"selection-rollout"},
    "demonstrations.randomise": set(),  # of one role's demonstrations alone
    "evaluation.simulator": {
        "rollout",
        "skill",
        "selection-rollout",
        "policies",
        "report",
    },  # notes below tables tell of it
    "evaluation.robot_init_noise": {"rollout", "skill", "selection-rollout", "policies", "report"},
    "evaluation.depth_noise": {"rollout", "selection-rollout", "policies", "report"},
    "evaluation.camera_error": {"rollout", "selection-rollout", "policies", "report"},
    "training.configs.lite.kwargs": {"train", "policies", "report"},  # tables name it
    "training.configs.lite.policy": {"train", "policies", "report"},  # what policies are called
    "training.configs.lite.handle": {"train", "policies", "report"},
    "evaluation.conditions": set(),  # read with a condition alone
    "tables": {"scenes", "policies", "conditions", "report", "picture"},
}
ONE = {"assets": {"snapshots"}, "matching": {"match"}}  # the command of the other keys of a section
Config = complete()
CONFIG = Config()


def told(stage: str, command: str) -> str:
    """A command, with its stage if another one has such a command."""
    return command if [name for _, name in READS].count(command) == 1 else f"{stage} {command}"


def leaves(section: BaseModel, path: str) -> list[str]:
    """Keys of a section that hold values."""
    found = []
    for name in type(section).model_fields:
        child, key = getattr(section, name), f"{path}.{name}"
        found += leaves(child, key) if isinstance(child, BaseModel) else [key]
    return found


def changed(section: Any, path: list[str]) -> Any:
    """A copy with another value, whatever it may be, under a key."""
    if not path:
        return section | {"cloud": False} if isinstance(section, dict) else "another value"
    if isinstance(section, dict):
        return section | {path[0]: changed(section[path[0]], path[1:])}
    return section.model_copy(update={path[0]: changed(getattr(section, path[0]), path[1:])})


def digests(config: Any) -> dict[str, str]:
    """What each command is told of a config, as text."""
    made = {}
    for stage, command in READS:
        wildcards = {"variant": "default", "run": "lite", "scene": "room_1"}
        if command == "features":
            made[command] = repr(sorted(stores(config)))
            continue
        made[told(stage, command)] = repr(options_of(config, stage, command, wildcards))
    return made


SECTIONS = dict.fromkeys(section_name(stage) for stage, _ in READS if stage != "training")
BESIDE = [section for package in find_packages().values() if package.judges for section in package.sections]
KEYS = [key for section in [*SECTIONS, *BESIDE] for key in leaves(getattr(CONFIG, section), section)]


@pytest.mark.parametrize("key", [*KEYS, *leaves(CONFIG.training.configs["lite"], "training.configs.lite")])
def test_a_key_runs_again_what_reads_it(key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    other = changed(CONFIG, key.split("."))

    def matching_of(self: Any, variant: str) -> MatchingConfig:
        beside = {section: getattr(self, section) for section in BESIDE}
        return matching_model(find_packages()).model_construct(**dict(self.matching), **beside)  # any value will do

    monkeypatch.setattr(Config, "matching_of", matching_of)
    monkeypatch.setattr(Config, "generation_of", lambda self, variant: self.generation)
    before, after = digests(CONFIG), digests(other)
    listed = [LISTED[prefix] for prefix in (key, key.rpartition(".")[0], key.partition(".")[0]) if prefix in LISTED]
    section = key.partition(".")[0]
    commands = [name for name in READS if section_name(name[0]) == section]
    own = [name for name in commands if key.split(".")[1] in READS[name].model_fields]
    only = ONE.get(section) or {told(*name) for name in own or commands}
    expected = (listed[0] if listed else only) & before.keys()  # a package with such a command may not be here
    assert {command for command in before if before[command] != after[command]} == expected


@pytest.mark.parametrize(("stage", "command"), READS)
def test_a_command_can_read_nothing_else(stage: str, command: str) -> None:
    """Its options are parsed by the model that they were made from, which refuses other keys."""
    tree = ast.parse((ROOT / home_of(stage).replace(".", "/") / f"{command.replace('-', '_')}.py").read_text())
    models = {
        node.args[0].id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "read_options"
        if isinstance(node.args[0], ast.Name)
    }
    models |= {"MatchingConfig"} if "read_options(matching_model(find_packages())" in ast.unparse(tree) else set()
    assert READS[stage, command].__name__ in models


def test_ranges_of_what_is_randomised_run_its_demonstrations_alone_again() -> None:
    for role in ("twin", "cousin_1", "cover_17", "all"):
        told = options_of(CONFIG, "demonstrations", "collect", {"target": "door", "role": role})
        assert "randomise" not in told, role
        told = options_of(CONFIG, "demonstrations", "collect", {"target": "door", "role": f"{role}_randomised"})
        assert "randomise" in told, role


def test_rules_pass_options_to_the_commands_that_read_any() -> None:
    for path in list_rule_files():
        for body in re.split(r"^(?:rule|checkpoint) ", path.read_text(), flags=re.MULTILINE)[1:]:
            for called in re.findall(r'\*\*command\(\s*"(\w+)",\s*"([\w-]+)"', body):
                assert (called in READS) == ("{params.options:q}" in body), called


def test_the_folder_of_clip_is_read_where_clip_is() -> None:
    assert "clip" in MatchingConfig(clip="a").list_unread()
    assert "clip" not in MatchingConfig(clip="a", text_encoder="clip").list_unread()


def test_variants_with_different_encoder_settings_have_stores_side_by_side() -> None:
    text = """
    experiment:
      variants:
        weights: {hog: {normals: 3.0, position: 1.0}, count_threshold: null, views: 8}
        fine: {hog: {grid: 24}}
    """
    default = with_defaults({})
    config = load(merge_mappings(default, yaml.safe_load(text)))
    shipped, weights, fine = (config.matching_of(name).store() for name in ("default", "weights", "fine"))
    assert shipped == weights != fine
    assert {name: options.hog.grid for name, options in stores(config).items()} == {shipped: 16, fine: 24}
    told = options_of(config, "matching", "features", {"store": fine})
    kept = {"dimensions": 0}
    assert told == {"encoder": "hog", "hog": {"image_size": 192, "grid": 24}} | kept


@needs("render_and_compare")
@pytest.mark.skipif(not is_there(DINOV2), reason="no weights of DINOv2")
def test_row_b_of_the_study_is_the_papers() -> None:
    theirs, ours = (read_files([ROOT / "config" / name]) for name in ("paper/scenes.yaml", "study/table2.yaml"))
    for variant in ("b", "b-votes"):
        assert ours.matching_of(variant) == theirs.matching_of(variant)
        placed = {"ranks": ours.generation.ranks}  # one rank is enough for the table
        assert ours.generation_of(variant) == theirs.generation.model_copy(update=placed)
