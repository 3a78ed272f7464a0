"""The config's own rules: which demonstrations each training set needs, and what a code digest covers."""

import ast
from pathlib import Path

import pytest
from pydantic import Field

from roomkin.stages.config.code import ROOTS, closure, code_digest, files_digest, forget
from roomkin.stages.config.evaluation import EvaluationConfig
from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.model import load
from roomkin.stages.config.names import COMMANDS
from roomkin.stages.config.packages import find_packages, home_of
from roomkin.stages.config.reference import write_yaml
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.section import Section
from tests.refusals import refused

ROOT = Path(__file__).resolve().parents[2]


def test_training_sets_leave_out_held_out_cousins() -> None:
    experiment = ExperimentConfig(cousins=10, held_out=[2, 6], episodes=80)
    assert experiment.roles("twin", 0) == ["twin"]
    assert experiment.roles("cousins_4", 3) == ["cousin_1", "cousin_3", "cousin_4", "cousin_5"]
    assert experiment.roles("all", 0) == ["all"]  # one store of its own
    assert experiment.share("door", "cousins_4") == 20 and experiment.share("door", "all") == 80


def test_an_asset_gives_as_many_episodes_as_the_neediest_set_asks() -> None:
    experiment = ExperimentConfig(training_sets=["twin", "cousins_2", "cousins_4"], episodes=80)
    assert experiment.episodes_of("door", "twin") == 80
    assert experiment.episodes_of("door", "cousin_1") == 40
    assert experiment.episodes_of("door", "cousin_4") == 20
    assert experiment.episodes_of("door", "cousin_2") == 0
    assert experiment.list_trained_roles("door") == ["cousin_1", "cousin_3", "cousin_4", "cousin_5", "twin"]


def test_training_sets_without_cousins_have_stores_of_their_own() -> None:
    experiment = ExperimentConfig(training_sets=["twin_randomised", "random_2", "random_4"], episodes=80)
    assert experiment.roles("twin_randomised", 0) == ["twin_randomised"]
    assert experiment.list_trained_roles("door") == ["random_1", "random_2", "random_3", "random_4", "twin_randomised"]
    assert [experiment.episodes_of("door", f"random_{number}") for number in (1, 3)] == [40, 20]
    assert experiment.episodes_of("door", "twin_randomised") == 80


def test_a_policy_has_more_episodes_on_the_twin_where_they_are_asked_for() -> None:
    options = EvaluationConfig(test_assets=["twin", "cousin_2"], rollouts=25, assets=10, asset_rollouts=3)
    assert options.episodes() == 2 * 25 + 10 * 3
    assert options.model_copy(update={"twin_rollouts": 60}).episodes() == 60 + 25 + 10 * 3


def test_every_seed_learns_from_a_draw_of_its_own() -> None:
    experiment = ExperimentConfig(training_sets=["random_2", "cover_1"], seeds=[0, 1, 3], draws=3, episodes=80)
    assert [experiment.roles("random_2", seed) for seed in (0, 1, 3)] == [
        ["random_1", "random_2"], ["random_17", "random_18"], ["random_1", "random_2"],
    ]  # fmt: skip
    assert experiment.roles("cover_1", 2) == ["cover_33"]
    assert experiment.list_trained_roles("door") == [
        "cover_1",
        "cover_17",
        "random_1",
        "random_17",
        "random_18",
        "random_2",
    ]
    assert experiment.episodes_of("door", "random_18") == 40 and experiment.episodes_of("door", "cover_33") == 0
    once = ExperimentConfig(draws=1)
    assert once.roles("random_8", 4) == once.roles("random_8", 0) == [f"random_{number}" for number in range(1, 9)]


def test_any_set_may_be_randomised() -> None:
    sets = ["cousins_2", "cousins_2_randomised", "all_randomised", "cover_1_randomised"]
    experiment = ExperimentConfig(training_sets=sets, held_out=[2], episodes=80)
    assert experiment.roles("cousins_2_randomised", 0) == ["cousin_1_randomised", "cousin_3_randomised"]
    assert experiment.roles("all_randomised", 0) == ["all_randomised"]
    assert experiment.roles("cover_1_randomised", 1) == ["cover_17_randomised"]
    assert experiment.share("door", "cousins_2_randomised") == 40
    assert experiment.list_trained_roles("door") == [
        "all_randomised", "cousin_1", "cousin_1_randomised", "cousin_3", "cousin_3_randomised", "cover_1_randomised",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "name", ["twin_2", "random", "random_0", "cover_8_wide", "skill", "near_8", "twin_randomised_2"]
)
def test_a_set_that_no_rule_makes_is_refused(name: str) -> None:
    with refused("E-CONFIG-VALUE", "experiment.training_sets.0"):
        load({"experiment": {"training_sets": [name]}})


def test_the_policies_of_a_target_share_its_demonstrations_and_options() -> None:
    near = {"task": "door", "options": {"max_steps": 200}, "episodes": 32}
    policies = {
        "lite": {"training_sets": ["twin", "cousins_4"]},
        "flag": {"configs": ["lite_x"], "targets": ["near"], "training_sets": ["cousins_2", "cousins_4"], "seeds": [5]},
    }
    runs = {"lite": {}, "lite_x": {"steps": 9}}
    config = load({"experiment": {"targets": {"near": near}, "policies": policies}, "training": {"configs": runs}})
    experiment = config.experiment
    assert experiment.plan("flag") == (["near"], ["lite_x"], ["cousins_2", "cousins_4"], [5])
    assert experiment.plan("lite") == (["near"], ["lite"], ["twin", "cousins_4"], [0])
    assert experiment.task("near") == "door" and config.task_of("near").max_steps == 200
    assert config.task_of("near").camera_eye == config.task.camera_eye
    # cousin_1 gives 8 to cousins_4 of both policies, 16 to cousins_2 of the other alone
    assert experiment.episodes_of("near", "cousin_1") == 16 and experiment.episodes_of("near", "cousin_5") == 8
    assert experiment.list_trained_roles("near") == ["cousin_1", "cousin_3", "cousin_4", "cousin_5", "twin"]


def test_a_policy_opens_every_target_or_those_that_it_names_also_by_their_pool() -> None:
    targets = {
        "door": {},
        "fridge_handle": {"task": "door"},
        "drawer": {"room": "room_2", "object": "chest_of_drawers_1"},
    }
    policies = {"lite": {}, "lite_handle": {"targets": ["doors"], "training_sets": ["all"]}}
    experiment = load(
        {"experiment": {"targets": targets, "policies": policies, "pools": {"doors": ["door", "fridge_handle"]}}}
    ).experiment
    assert experiment.cells == [
        ("door", "lite", "twin"), ("door", "lite", "cousins_4"), ("door", "lite_handle", "all"),
        ("fridge_handle", "lite", "twin"), ("fridge_handle", "lite", "cousins_4"),
        ("fridge_handle", "lite_handle", "all"), ("drawer", "lite", "twin"), ("drawer", "lite", "cousins_4"),
    ]  # fmt: skip
    assert experiment.sets_of("drawer") == ["cousins_4", "twin"] and "all" in experiment.list_trained_roles("door")


def test_what_the_default_has_comes_first_however_files_are_merged() -> None:
    policies = {"diffusion": {"configs": ["lite"]}, "lite_handle": {}, "lite": {}}
    assert list(load({"experiment": {"policies": policies}}).experiment.policies) == [
        "lite",
        "lite_handle",
        "diffusion",
    ]


def test_unknown_key_suggests_the_right_one() -> None:
    with refused("E-CONFIG-KEY", "did you mean 'seed'"):
        load({"sed": 1})


def test_code_digest_follows_imports_but_not_other_stages() -> None:
    modules = closure("roomkin.stages.matching.match")
    assert "roomkin.stages.matching.match" in modules
    assert "roomkin.stages.contracts.cousins" in modules
    assert not any(module.startswith("roomkin.stages.training") for module in modules)
    assert (
        "roomkin.stages.contracts.policies" not in modules
    )  # re-exports of roomkin.stages.contracts are followed by name
    assert code_digest("roomkin.stages.matching.match") != code_digest("roomkin.stages.tables.policies")


def test_code_digest_follows_what_a_registry_names_as_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "toy_registry"
    package.mkdir()
    (package / "main.py").write_text('WAYS = {"a": "toy_registry.plain", "b": "toy_registry.chosen:Class"}')
    for name in ("plain", "chosen", "unused"):
        (package / f"{name}.py").write_text("")
    monkeypatch.setitem(ROOTS, "toy_registry", package)
    forget()  # where a digest of this file was made, its texts name no modules yet
    assert closure("toy_registry.main") == ("toy_registry.chosen", "toy_registry.main", "toy_registry.plain")
    before = code_digest("toy_registry.main")
    for name in ("unused", "chosen"):
        (package / f"{name}.py").write_text("x = 1")
        forget()
        assert (code_digest("toy_registry.main") != before) == (name == "chosen")


@pytest.mark.parametrize(
    ("stages", "message"),
    [
        ({"maching": {}}, "stages: no stage is called 'maching'; did you mean 'matching'"),
        (
            {"matching": {"command": "./mine.sh"}},
            "stages: no command of matching is called 'command'; there are: features, shards, match",
        ),
        (
            {"matching": {"macth": {"command": "x"}}},
            "stages: no command of matching is called 'macth'; did you mean 'match'",
        ),
        ({"matching": {"match": {"code": []}}}, "stages.matching.match.command: Field required"),
    ],
)
def test_only_commands_that_exist_are_replaced(stages: dict, message: str) -> None:
    with pytest.raises(InputError) as caught:
        load({"stages": stages})
    assert message in str(caught.value)


FOR_PEOPLE = {  # pages and helpers that no rule calls: there is nothing to replace
    "furniture facts",
    "importing import",
    "ops cluster",
    "studies objects",
    "studies quote",
    "studies results",
}


@pytest.mark.parametrize("stage", [*COMMANDS, *(name for name, package in find_packages().items() if package.commands)])
def test_every_command_can_be_replaced(stage: str) -> None:
    tree = ast.parse((ROOT / home_of(stage).replace(".", "/") / "__main__.py").read_text())
    offered = next(node for node in ast.walk(tree) if isinstance(node, ast.Dict))
    called_by_rules = [command for command in ast.literal_eval(offered) if f"{stage} {command}" not in FOR_PEOPLE]
    assert called_by_rules == list(COMMANDS[stage] if stage in COMMANDS else find_packages()[stage].commands)


def test_digest_of_code_files_sees_edits_and_names_not_caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lib").mkdir()
    (tmp_path / "mine.sh").write_text("echo")
    (tmp_path / "lib/part.py").write_text("a = 1")
    first = files_digest(["mine.sh", "lib"])
    (tmp_path / "lib/__pycache__").mkdir()
    (tmp_path / "lib/__pycache__/part.pyc").write_bytes(b"1")
    assert files_digest(["mine.sh", "lib"]) == first
    (tmp_path / "lib/part.py").write_text("a = 2")
    second = files_digest(["mine.sh", "lib"])
    (tmp_path / "lib/part.py").rename(tmp_path / "lib/other.py")
    assert len({first, second, files_digest(["mine.sh", "lib"])}) == 3
    with pytest.raises(FileNotFoundError):
        files_digest(["gone.sh"])


def test_a_written_config_says_what_every_key_means_and_what_is_allowed() -> None:
    class Some(Section):
        length: float = Field(1.5, ge=0, description="Of a side.")
        name: str = Field("a", description="Any.")

    assert write_yaml(Some()) == "# Of a side. [>= 0]\nlength: 1.5\n# Any.\nname: a\n"
