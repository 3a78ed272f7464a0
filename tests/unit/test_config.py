"""The config's own rules: which demonstrations each training set needs, and what a code digest covers."""

import pytest

from stages.config.code import closure, code_digest
from stages.config.experiment import ExperimentConfig
from stages.config.model import load
from stages.contracts import InputError


def test_training_sets_leave_out_held_out_cousins() -> None:
    experiment = ExperimentConfig(cousins=10, held_out=[2, 6], episodes=80)
    assert experiment.roles("twin") == ["twin"]
    assert experiment.roles("cousins_4") == ["cousin_1", "cousin_3", "cousin_4", "cousin_5"]
    assert len(experiment.roles("all")) == 8
    assert experiment.share("cousins_4") == 20
    with pytest.raises(ValueError, match="cousins_8"):
        ExperimentConfig(cousins=5, held_out=[2]).roles("cousins_8")


def test_an_asset_gives_as_many_episodes_as_the_neediest_set_asks() -> None:
    experiment = ExperimentConfig(training_sets=["twin", "cousins_2", "cousins_4"], episodes=80)
    assert experiment.episodes_of("twin") == 80
    assert experiment.episodes_of("cousin_1") == 40
    assert experiment.episodes_of("cousin_4") == 20
    assert experiment.episodes_of("cousin_2") == 0


def test_unknown_key_suggests_the_right_one() -> None:
    with pytest.raises(InputError, match="did you mean 'seed'"):
        load({"sed": 1})


def test_code_digest_follows_imports_and_registries_but_not_other_stages() -> None:
    modules = closure("stages.matching.match")
    assert "stages.matching.match" in modules
    assert "stages.contracts.cousins" in modules
    assert not any(module.startswith("stages.training") for module in modules)
    assert "stages.contracts.policies" not in modules  # re-exports of stages.contracts are followed by name
    assert code_digest("stages.matching.match") != code_digest("stages.tables.tables")
