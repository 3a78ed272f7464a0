"""The whole of config.yaml: one typed section per stage."""

from collections.abc import Callable, Iterable, Iterator
from functools import reduce
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, field_validator

from roomkin.stages.config.assets import AssetsConfig
from roomkin.stages.config.contradictions import contradictions
from roomkin.stages.config.evaluation import EvaluationConfig, TablesConfig
from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.files import ContainersConfig, read_file
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.config.matching import MatchingConfig, MatchingSection, matching_model
from roomkin.stages.config.mistakes import Mistake, mistakes_of, tell_package, truths, validate_config, without_removed
from roomkin.stages.config.names import Replaced, resolve_names
from roomkin.stages.config.packages import Objects, Package, find_packages, packages_on, with_sections
from roomkin.stages.config.perception import PerceptionSection
from roomkin.stages.config.pictures import mark_measured, of_picture, read_sources
from roomkin.stages.config.targets import RoomTarget
from roomkin.stages.config.training import DemonstrationsConfig, TrainingSection
from roomkin.stages.config.weights import leave_out, list_unfetched
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.contracts.section import Section, Seed
from roomkin.stages.plugins import find, folder
from roomkin.stages.plugins import load as load_plugin


class Config(Section):
    """Config of the workflow. What is not set keeps the default given here."""

    seed: Seed = Field(0, description="Seed of everything random: library, rooms, noise, demonstrations, rollouts.")
    image: str = Field(
        "",
        description="A picture, for the target `photo`: the one scene in the place of `experiment.rooms`, without "
        'tasks (docs/your-data.md). "": none.',
    )
    depth: str = Field("", description="Depth of the picture `image`, aligned to it.")
    camera: str = Field("", description="Its intrinsics: a file, or the camera's name (docs/your-data.md).")
    packages: dict[str, bool] = Field(
        default_factory=lambda: dict.fromkeys(find_packages(), True),
        description="Packages beside the core (docs/architecture.md), and which are on.",
    )
    plugins: list[str] = Field(
        [],
        description="Packages of yours with further implementations (docs/extending.md): in this folder, installed, "
        "or on PYTHONPATH.",
    )
    device: Literal["cpu", "cuda"] = Field("cpu", description="Where networks are trained and run.")
    experiment: ExperimentConfig = Field(ExperimentConfig(), description="Which cells of the paper's tables are run.")
    assets: AssetsConfig = Field(AssetsConfig(), description="The asset library and its snapshots (A.1).")
    perception: PerceptionSection = Field(
        PerceptionSection(), description="From a picture of yours to an input folder (2.1, A.2, A.7)."
    )
    extraction: ExtractionConfig = Field(ExtractionConfig(), description="From image to objects in space (A.2, A.7).")
    matching: MatchingSection = Field(MatchingSection(), description="Digital cousins of every object (A.6, A.7, B.1).")
    generation: GenerationConfig = Field(GenerationConfig(), description="Placing the cousins (A.3, A.7).")
    task: TaskConfig = Field(
        TaskConfig(), description="The tasks' environment, the same in demos and evaluation (B.3)."
    )
    demonstrations: DemonstrationsConfig = Field(
        DemonstrationsConfig(), description="Automatic demonstrations (A.4, A.5)."
    )
    training: TrainingSection = Field(TrainingSection(), description="Policies (B.3).")
    evaluation: EvaluationConfig = Field(EvaluationConfig(), description="Rollouts and scene scores (B.1, B.3).")
    tables: TablesConfig = Field(TablesConfig(), description="Tables, figures and the report page.")
    stages: Replaced = Field(
        {},
        description="Replace commands of stages by commands of yours, "
        "e.g. {matching: {match: {command: python mine.py, code: [mine.py]}}} (docs/extending.md).",
    )
    containers: ContainersConfig = Field(ContainersConfig(), description="Images of the rules, for `--sdm apptainer`.")

    @field_validator("packages")
    @classmethod
    def _fill_packages(cls, given: dict[str, bool]) -> dict[str, bool]:
        """Those that are not named are on."""
        here = find_packages()
        for name in given:
            if name not in here:
                raise ValueError(f"there is no package '{name}'; {tell_package(name, suggest_nearest(name, here))}")
        return dict.fromkeys(here, True) | given

    @property
    def implementations(self) -> list[str]:
        """The packages in which implementations are looked for, beside the core: those that are on, then the user's."""
        ours = [f"roomkin.plugins.{name}" for name, on in self.packages.items() if on]
        return [*ours, *(name for name in self.plugins if name not in ours)]

    def matching_of(self, variant: str) -> MatchingConfig:
        """The options of one variant: `matching` and packages' sections, with what it changes, key by key."""
        known = type(self).model_fields.keys()
        model = matching_model(name for name, each in find_packages().items() if each.sections.keys() <= known)
        beside = {name: getattr(self, name).model_dump() for name in model.list_package_sections()}
        changed = merge_mappings(self.matching.model_dump() | beside, self.experiment.variants[variant])
        return resolve_names(model.model_validate(changed), self.implementations, f"experiment.variants.{variant}")

    def generation_of(self, variant: str) -> GenerationConfig:
        """The placing of one variant: that of `generation` with what differs, key by key."""
        changes = self.experiment.placements.get(variant, {})
        return GenerationConfig.model_validate(merge_mappings(self.generation.model_dump(), changes))

    def wears_picture(self, variant: str, scene: str) -> bool:
        """Whether the models of a scene have the colors of its picture: those of pictures of the user's by default."""
        finish = self.generation_of(variant).finish
        return finish == "picture" if finish else scene in self.experiment.inputs

    def task_of(self, target: str) -> TaskConfig:
        """The task options of a target: those of `task` with what it changes, key by key."""
        changes = self.experiment.targets[target].options
        return TaskConfig.model_validate(merge_mappings(self.task.model_dump(), changes))

    def rooms(self) -> dict[str, Objects]:
        """The rooms that packages make, by their names."""
        return {name: room for package in packages_on(self.packages) for name, room in package.rooms(self).items()}

    def implementation(self, kind: str, name: str) -> str:
        """The name by which a stage loads an implementation."""
        return find(kind, name, self.implementations)

    def can_simulate(self, target: str, simulator: str) -> bool:
        """Whether a simulator has a target's task: others than that of the demonstrations have those of one skill."""
        task = self.experiment.task(target)
        return simulator == "maniskill" or len(load_plugin("tasks", self.implementation("tasks", task)).skills) == 1

    def targets_under(self, condition: str) -> list[str]:
        """The targets whose task the simulator of a condition has."""
        simulator = self.evaluation.under(condition).simulator
        return [target for target in self.experiment.targets if self.can_simulate(target, simulator)]


def merge_mappings(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """`base` with `changes`; mappings in mappings are merged, everything else is replaced."""
    both = [key for key, value in changes.items() if isinstance(value, dict) and isinstance(base.get(key), dict)]
    return base | changes | {key: merge_mappings(base[key], changes[key]) for key in both}


def with_defaults(config: dict[str, Any]) -> dict[str, Any]:
    """A config with all that it leaves out, as far down as names go: it need only hold what differs."""
    defaults = complete()().model_dump(mode="json")
    assets = config.get("assets")
    if isinstance(assets, dict) and assets.get("only") is True:
        defaults["assets"]["counts"] = dict.fromkeys(defaults["assets"]["counts"], 0)
    return merge_mappings(defaults, config)


def read_files(files: Iterable[Path]) -> Config:
    """The config of a run with these files over the defaults, later ones over earlier ones.

    Raises:
        InputError: a file cannot be read, or the config has mistakes.
    """
    return load(with_defaults(reduce(merge_mappings, map(read_file, files), {})))


def load(config: dict[str, Any], rooms_named: bool = True) -> Config:
    """Validate a merged config.

    Args:
        rooms_named: False: `experiment.rooms` names none, as stages are called by hand (plugins/api).

    Raises:
        InputError: names all mistakes, a line each, with key and mend.
    """
    on = _packages_on(config)
    model = with_sections(Config, on)
    silent = {section for package in find_packages().values() for section in package.sections} - set(model.model_fields)
    config = {key: value for key, value in config.items() if key not in silent}
    config, unread = read_sources(config)
    valid, mistakes = validate_config(model, without_removed(config, model))
    mistakes += unread
    wrong = [mistake.key for mistake in mistakes] + (["experiment.rooms"] if unread else [])
    valid = valid.model_copy(update={"plugins": _packages(valid.plugins, mistakes)})
    valid = resolve_names(valid, valid.implementations, "", mistakes)
    mistakes += _overlays(valid)
    rooms = valid.experiment.model_copy(update={"rooms": valid.experiment.named()})
    valid = valid.model_copy(update={"experiment": rooms})
    valid = of_picture(leave_out(valid, list_unfetched(valid))) if not mistakes else valid
    mark_measured(valid)
    mistakes += [each for each in contradictions(valid) if not any(_overlap(each.key, key) for key in wrong)]
    if not rooms_named:
        mistakes = [each for each in mistakes if each.key != "experiment.rooms"]
    if mistakes:
        lines = [str(mistake) for mistake in mistakes]
        heading = f"{len(lines)} mistakes:\n  " if len(lines) > 1 else ""
        code = mistakes[0].code if len(mistakes) == 1 else "E-CONFIG"
        raise InputError("config", heading + "\n  ".join(lines), code=code)
    return valid


def complete() -> type[Config]:
    """The config with the sections of all packages that are here."""
    return with_sections(Config, find_packages())


def _packages_on(config: dict[str, Any]) -> dict[str, Package]:
    """The packages that a config does not turn off, by name."""
    given = config.get("packages")
    off = [name for name, on in given.items() if on is False] if isinstance(given, dict) else []
    return {name: package for name, package in find_packages().items() if name not in off}


def _overlays(config: Config) -> Iterator[Mistake]:
    """Mistakes in the keys that variants, placements and targets change; such changes are taken back."""
    kinds: tuple[tuple[str, type[Section], Callable[[str], Section]], ...] = (
        ("variants", MatchingConfig, config.matching_of),
        ("placements", GenerationConfig, config.generation_of),
        ("targets", TaskConfig, config.task_of),
    )
    for section, model, read in kinds:
        entries = getattr(config.experiment, section)
        for name, entry in list(entries.items()):
            key, changes = f"experiment.{section}.{name}", entry
            if isinstance(entry, RoomTarget):
                key, changes = f"{key}.options", entry.options
            yield from truths(changes, model, key)
            try:
                read(name)
                continue
            except ValidationError as error:
                yield from mistakes_of(model, error, f"{key}.")
            except InputError as error:
                yield Mistake.of(error)
            entries[name] = entry.model_copy(update={"options": {}}) if isinstance(entry, RoomTarget) else {}


def _packages(names: list[str], mistakes: list[Mistake]) -> list[str]:
    """The packages that are there."""
    there = []
    for name in names:
        try:
            folder(name)
            there.append(name)
        except InputError as error:
            mistakes.append(Mistake.of(error))
    return there


def _overlap(one: str, other: str) -> bool:
    """Whether one key lies in the other."""
    return f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}.")
