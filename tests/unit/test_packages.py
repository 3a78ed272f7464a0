"""Packages beside the core: which are on, and what of the config is theirs."""

from pathlib import Path
from typing import Any

import pytest

from roomkin.stages.config.model import load
from roomkin.stages.config.packages import check_rules, check_targets, find_packages, home_of
from roomkin.stages.config.reads import READS, options_of, stores
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.section import Section
from roomkin.stages.plugins import list_available
from tests.packages import needs
from tests.refusals import refused
from tests.workflow.workspace import ROOT

pytestmark = needs("exports", "importing", "mujoco", "pretrained", "studies", "vlm")  # what the tests turn on and off


def test_all_that_are_here_are_on_unless_one_says_otherwise() -> None:
    config = load({"packages": {"mujoco": False}})
    assert config.packages == dict.fromkeys(find_packages(), True) | {"mujoco": False}
    assert (
        "roomkin.plugins.mujoco" not in config.implementations and "roomkin.plugins.exports" in config.implementations
    )


def test_a_package_that_is_off_offers_no_implementation() -> None:
    with refused("E-PLUGIN-UNKNOWN", "evaluation.simulator: there is no 'mujoco'"):
        load({"packages": {"mujoco": False}, "evaluation": {"simulator": "mujoco"}})


def test_a_package_that_is_not_here_is_told() -> None:
    with refused("E-CONFIG-VALUE", "packages: there is no package 'mujocco'; did you mean 'mujoco'"):
        load({"packages": {"mujocco": True}})


LEFT = {"matching": {"model_selection": "distance", "orientation_selection": "distance"}}  # the core's judge


@pytest.mark.parametrize("name", [name for name, package in find_packages().items() if package.sections])
def test_a_section_belongs_to_its_package(name: str) -> None:
    """It is left out, also where a file gives it, if its package is off."""
    sections = find_packages()[name].sections
    given = {section: {} for section, (kind, _) in sections.items() if issubclass(kind, Section)}
    on, off = load(given), load(given | LEFT | {"packages": {name: False}}, rooms_named=name != "scenes")
    assert all(hasattr(on, section) and not hasattr(off, section) for section in sections)


def test_commands_are_found_in_their_homes() -> None:
    assert home_of("matching") == "roomkin.stages.matching" and home_of("exports") == "roomkin.plugins.exports"
    assert list_available("simulators")["mujoco"] == "roomkin.plugins.mujoco.simulators.mujoco"


@pytest.mark.parametrize("name", find_packages())
def test_a_run_is_planned_without_any_of_them_or_says_what_wants_it(name: str) -> None:
    if name == "furniture":
        with refused(
            "E-CONFIG-CLASH", "assets.counts: is read by the package furniture", "packages: {furniture: true}"
        ):
            load({"packages": {name: False}})
        return
    if name == "render_and_compare":
        mend = "packages: {render_and_compare: true}, or one of distance, votes"
        with refused("E-CONFIG", "matching.model_selection: there is no 'geometry'", mend):
            load({"packages": {name: False}})
    packages, given = {name: False}, dict[str, Any](LEFT)
    if name == "scripted":
        with refused("E-CONFIG-CLASH", "packages.scripted: is off or not here, and studies"):
            load({"packages": packages})
        packages |= {"studies": False}
    if name == "scenes":
        with refused("E-CONFIG", "experiment.rooms: unknown scene 'room_1'. Fix: packages: {scenes: true}"):
            load({"packages": packages})
    if name == "pictures":
        with refused("E-CONFIG", "packages.pictures: is off or not here, and pages of the report"):
            load({"packages": packages})
        packages |= {"report": False, "exports": False}
    config = load(given | {"packages": packages}, rooms_named=name != "scenes")
    wildcards = {"variant": "default", "run": "lite", "scene": "", "store": next(iter(stores(config)))}
    for stage, command in READS:
        if stage != name:
            options_of(config, stage, command, wildcards)


@pytest.mark.parametrize(
    ("name", "changes", "key"),
    [
        ("importing", {"assets": {"folders": ["mine"]}}, "assets.folders"),
        ("pretrained", {"perception": {"proposers": ["grounding"]}}, "perception.proposers"),
        ("pretrained", {"perception": {"by": "networks"}, "image": "a.png"}, "perception.by"),
        ("studies", {"evaluation": {"conditions": {"far": {"robot_init_noise": [0.1, 5]}}}}, "evaluation.conditions"),
        ("vlm", {"perception": {"captions": "vlm"}, "image": "a.png"}, "perception.captions"),
        ("vlm", {"matching": {"model_selection": "vlm"}}, "matching.model_selection"),
    ],
)
def test_what_a_package_that_is_off_would_read_is_not_lost(
    name: str, changes: dict[str, Any], key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine/chair").mkdir(parents=True)
    (tmp_path / "mine/chair/seat.obj").touch()
    (tmp_path / "a.png").touch()
    with pytest.raises(InputError, match=key):
        load({"packages": {name: False}} | changes)


@pytest.mark.parametrize(
    ("target", "name"), [("overview", "report"), ("exports", "exports"), ("open_rooms", "studies")]
)
def test_targets_of_a_package_that_is_off_are_refused(target: str, name: str) -> None:
    on = dict.fromkeys(find_packages(), True)
    check_targets([target, "photo", "all"], on, "a.jpg")
    with refused("E-CONFIG-CLASH", f"{target}: is a target of the package {name}", f"packages: {{{name}: true}}"):
        check_targets(["-n", target], on | {name: False})


def test_a_target_that_does_not_exist_is_told_with_the_nearest() -> None:
    ours = str(ROOT / "Snakefile")
    with refused("E-WORDS", "tabel2: is no target. Fix: did you mean 'table2'?"):
        check_rules(["/bin/snakemake", "--cores", "2", "tabel2", "--configfile", "mine.yaml"], ours)
    for known in ("table2", "everything", "shards", "results/tables/tabel2.csv", "tabel2.csv"):
        check_rules(["snakemake", "--cores", "2", known], ours)
    check_rules(["snakemake", "tabel2"], "/elsewhere/Snakefile")  # which has ours as a module, and rules of its own
    check_rules(["pytest", "tabel2"], ours)
