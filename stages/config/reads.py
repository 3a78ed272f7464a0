"""The part of the config that each command reads: its --options hold no more, so that no other change runs it again."""

import json
from typing import Any

from roomkin.stages.config.assets import SnapshotOptions
from roomkin.stages.config.evaluation import PolicyTables, RolloutOptions, SelectionOptions, TablesConfig
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.config.matching import CandidateOptions, ComparisonOptions, EncoderOptions, matching_model
from roomkin.stages.config.model import Config
from roomkin.stages.config.names import kind_of
from roomkin.stages.config.packages import find_packages
from roomkin.stages.config.perception import DrawOptions, MeasureOptions, SeeOptions
from roomkin.stages.config.training import DemonstrationsConfig, policy_tables
from roomkin.stages.contracts.policy_config import PolicyConfig, is_randomised
from roomkin.stages.contracts.section import Section
from roomkin.stages.plugins import shorten_name

CORE: dict[tuple[str, str], type[Section]] = {
    ("assets", "snapshots"): SnapshotOptions,
    ("perception", "see"): SeeOptions,
    ("perception", "draw"): DrawOptions,
    ("perception", "measure"): MeasureOptions,
    ("extraction", "extract"): ExtractionConfig,
    ("matching", "features"): EncoderOptions,
    ("matching", "shards"): CandidateOptions,
    ("matching", "match"): matching_model(find_packages()),
    ("matching", "distances"): ComparisonOptions,
    ("generation", "generate"): GenerationConfig,
    ("demonstrations", "collect"): DemonstrationsConfig,
    ("training", "train"): PolicyConfig,
    ("evaluation", "selection-rollout"): SelectionOptions,
    ("evaluation", "rollout"): RolloutOptions,
    ("tables", "scenes"): TablesConfig,
    ("tables", "policies"): PolicyTables,
}
_commands = [(name, *each) for name, package in find_packages().items() for each in package.commands.items()]
READS = CORE | {(name, command): reads for name, command, reads in _commands if reads is not None}
# Wildcards of rules by which the options of a command differ.
WILDCARDS = ("scene", "variant", "store", "role", "run", "condition")


def section_name(stage: str) -> str:
    """The config section of a stage or package."""
    package = find_packages().get(stage)
    return package.section if package else stage


def section_of(config: Config, stage: str, wildcards: dict[str, str]) -> Section:
    """The section that a stage's commands read: that of a variant, config or perturbation where there are several."""
    if "variant" in wildcards and stage == "matching":
        return config.matching_of(wildcards["variant"])
    if "variant" in wildcards and stage == "generation":
        return config.generation_of(wildcards["variant"])
    if stage == "training":
        return config.training.configs[wildcards["run"]]
    if section_name(stage) == "evaluation" and "condition" in wildcards:
        return config.evaluation.under(wildcards["condition"])
    if section_name(stage) == "tables":
        return policy_tables(config)
    section: Section = getattr(config, section_name(stage))
    if isinstance(section, ExtractionConfig) and not config.experiment.scene(wildcards["scene"]).options.scale_error:
        return section.model_copy(update={"noise": section.noise.model_copy(update={"scale": 0.0})})
    return section


def options_of(config: Config, stage: str, command: str, wildcards: dict[str, str]) -> dict[str, Any]:
    """The --options of a command."""
    if (stage, command) == ("matching", "features"):
        return stores(config)[wildcards["store"]].keep_stored()
    section, reads = section_of(config, stage, wildcards), READS[stage, command]
    kinds = [field for field in type(section).model_fields if kind_of(type(section), field)]
    if beside := {name: getattr(config, name).model_dump() for name in _sections(reads, section, config)}:
        section = reads.model_construct(**dict(section), **beside)
    kept = section.model_dump(mode="json", include=set(reads.model_fields) - section.list_unread())
    if "kwargs" in kept and (len(kinds) > 1 or isinstance(getattr(section, kinds[0]), list)):  # by name
        values = [getattr(section, field) for field in set(kinds) & set(reads.model_fields)]
        used = {shorten_name(name) for value in values for name in ([value] if isinstance(value, str) else value)}
        kept["kwargs"] = {name: options for name, options in kept["kwargs"].items() if name in used}
    if not is_randomised(wildcards.get("role", "")):
        kept.pop("randomise", None)  # of such roles' demonstrations alone
    return kept


def _sections(reads: type[Section], section: Section, config: Config) -> list[str]:
    """Sections that a command reads beside its own, of packages that are on."""
    names = {name for package in find_packages().values() for name in package.sections if hasattr(config, name)}
    return sorted(names & set(reads.model_fields) - set(type(section).model_fields))


def describe_picture(config: Config, command: str, scene: str) -> str:
    """The --options, JSON, of a command of perception for one picture of the user's: its own field of view; other
    proposers where a network measures its depth."""
    one = config.experiment.inputs[scene]
    section = config.perception.for_measured() if one.measured and command == "see" else config.perception
    found = options_of(config.model_copy(update={"perception": section}), "perception", command, {})
    own = {"field_of_view": one.fov} if one.fov and "field_of_view" in found else {}
    return json.dumps(found | own, sort_keys=True)


def stores(config: Config) -> dict[str, EncoderOptions]:
    """The feature stores of a run by name."""
    return {options.store(): options for options in map(config.matching_of, config.experiment.variants)}
