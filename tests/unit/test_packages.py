"""Packages beside the core: which are on, and what of the config is theirs."""

import pytest

from stages.config.model import load
from stages.config.packages import home_of, present
from stages.plugins import available
from tests.refusals import refused


def test_all_that_are_here_are_on_unless_one_says_otherwise() -> None:
    config = load({"packages": {"mujoco": False}})
    assert config.packages == dict.fromkeys(present(), True) | {"mujoco": False}
    assert "plugins.mujoco" not in config.implementations and "plugins.exports" in config.implementations


def test_a_package_that_is_off_offers_no_implementation() -> None:
    with refused("E-PLUGIN-UNKNOWN", "evaluation.simulator: there is no 'mujoco'"):
        load({"packages": {"mujoco": False}, "evaluation": {"simulator": "mujoco"}})


def test_a_package_that_is_not_here_is_told() -> None:
    with refused("E-CONFIG-VALUE", "packages: there is no package 'mujocco'; did you mean 'mujoco'"):
        load({"packages": {"mujocco": True}})


@pytest.mark.parametrize("name", [name for name, package in present().items() if package.sections])
def test_a_section_belongs_to_its_package(name: str) -> None:
    """It is left out, also where a file gives it, if its package is off."""
    sections = present()[name].sections
    given = {section: {} for section in sections}
    on, off = load(given), load(given | {"packages": {name: False}})
    assert all(hasattr(on, section) and not hasattr(off, section) for section in sections)


def test_verbs_are_found_in_their_homes() -> None:
    assert home_of("matching") == "stages.matching" and home_of("exports") == "plugins.exports"
    assert available("simulators")["mujoco"] == "plugins.mujoco.simulators.mujoco"
