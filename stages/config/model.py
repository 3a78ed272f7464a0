"""The whole of config.yaml: one typed section per stage."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError

from stages.config.assets import AssetsConfig
from stages.config.containers import ContainersConfig
from stages.config.contradictions import contradictions
from stages.config.demonstrations import DemonstrationsConfig
from stages.config.evaluation import EvaluationConfig
from stages.config.experiment import ExperimentConfig
from stages.config.extraction import ExtractionConfig
from stages.config.generation import GenerationConfig
from stages.config.inputs import Input, scene_of, with_inputs
from stages.config.matching import MatchingConfig, MatchingSection
from stages.config.mistakes import Mistake, mistakes_of, truths, validated, without_removed
from stages.config.names import resolved
from stages.config.photo import PhotoSection
from stages.config.replaced import Replaced
from stages.config.room_files import room_files
from stages.config.scenes import ScenesConfig
from stages.config.tables import TablesConfig
from stages.config.targets import Target
from stages.config.training import TrainingConfig
from stages.config.vlm import VlmConfig
from stages.contracts.errors import InputError
from stages.contracts.section import Section, Seed
from stages.contracts.task_options import TaskConfig
from stages.plugins import find, folder
from stages.plugins import load as load_plugin


class Config(Section):
    """Config of the workflow. What is not set keeps the default given here."""

    seed: Seed = Field(0, description="Seed of everything random: library, rooms, noise, demonstrations, rollouts.")
    image: str = Field(
        "",
        description="A picture, for the target `photo`: the one scene in the place of `experiment.rooms`, without "
        'tasks (docs/your-data.md). "": none.',
    )
    plugins: list[str] = Field(
        [],
        description="Packages of yours with further implementations (docs/extending.md): in this folder, installed, "
        "or on PYTHONPATH.",
    )
    device: Literal["cpu", "cuda"] = Field("cpu", description="Where networks are trained and run.")
    experiment: ExperimentConfig = Field(ExperimentConfig(), description="Which cells of the paper's tables are run.")
    assets: AssetsConfig = Field(AssetsConfig(), description="The asset library and its snapshots (A.1).")
    scenes: ScenesConfig = Field(ScenesConfig(), description="The sim-to-sim rooms (B.1, Table 2).")
    photo: PhotoSection = Field(PhotoSection(), description="From one RGB picture to an input folder (A.2, A.7).")
    extraction: ExtractionConfig = Field(ExtractionConfig(), description="From image to objects in space (A.2, A.7).")
    matching: MatchingSection = Field(MatchingSection(), description="Digital cousins of every object (A.6, A.7, B.1).")
    vlm: VlmConfig = Field(
        VlmConfig(),
        description="The language model that sees, for the judge `vlm` and for `photo.captions: vlm` (docs/vlm.md).",
    )
    generation: GenerationConfig = Field(GenerationConfig(), description="Placing the cousins (A.3, A.7).")
    task: TaskConfig = Field(
        TaskConfig(), description="The tasks' environment, the same in demos and evaluation (B.3)."
    )
    demonstrations: DemonstrationsConfig = Field(
        DemonstrationsConfig(), description="Automatic demonstrations (A.4, A.5)."
    )
    training: TrainingConfig = Field(TrainingConfig(), description="Policies (B.3).")
    evaluation: EvaluationConfig = Field(EvaluationConfig(), description="Rollouts and scene scores (B.1, B.3).")
    tables: TablesConfig = Field(TablesConfig(), description="Tables, figures and the report page.")
    stages: Replaced = Field(
        {},
        description="Replace verbs of stages by commands of yours, "
        "e.g. {matching: {match: {command: python mine.py, code: [mine.py]}}} (docs/extending.md).",
    )
    containers: ContainersConfig = Field(ContainersConfig(), description="Images of the rules, for `--sdm apptainer`.")

    def matching_of(self, variant: str) -> MatchingConfig:
        """The matching options of one variant: `matching` and `vlm` with what the variant changes, key by key."""
        sections = self.matching.model_dump() | {"vlm": self.vlm.model_dump()}
        changed = merged(sections, self.experiment.variants[variant])
        return resolved(MatchingConfig.model_validate(changed), self.plugins, f"experiment.variants.{variant}")

    def generation_of(self, variant: str) -> GenerationConfig:
        """The placing of one variant: that of `generation` with what differs, key by key."""
        changes = self.experiment.placements.get(variant, {})
        return GenerationConfig.model_validate(merged(self.generation.model_dump(), changes))

    def task_of(self, target: str) -> TaskConfig:
        """The task options of a target: those of `task` with what it changes, key by key."""
        return TaskConfig.model_validate(merged(self.task.model_dump(), self.experiment.targets[target].options))

    def room_files(self) -> dict[str, Path]:
        """Files of all rooms that could be asked for, by their names."""
        return room_files(self.experiment.room_files, self.plugins)

    def implementation(self, kind: str, name: str) -> str:
        """The name by which a stage loads an implementation."""
        return find(kind, name, self.plugins)

    def simulated(self, target: str, simulator: str) -> bool:
        """Whether a simulator has the task of a target: MuJoCo has those of one skill."""
        task = self.experiment.task(target)
        return simulator != "mujoco" or len(load_plugin("tasks", self.implementation("tasks", task)).skills) == 1


def merged(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """`base` with `changes`; mappings in mappings are merged, everything else is replaced."""
    both = {key: merged(base[key], value) for key, value in changes.items() if _mappings(base.get(key), value)}
    return base | changes | both


def _mappings(*values: Any) -> bool:
    return all(isinstance(value, dict) for value in values)


def load(config: dict[str, Any], rooms_named: bool = True) -> Config:
    """Validate a merged config.

    Args:
        rooms_named: False: `experiment.rooms` names none, as stages are called by hand (stages/api.py).

    Raises:
        InputError: names all mistakes, a line each, with key and mend.
    """
    config, unread = with_inputs(config)
    valid, mistakes = validated(Config, without_removed(config, Config))
    mistakes += unread
    wrong = [mistake.key for mistake in mistakes] + (["experiment.rooms"] if unread else [])
    valid = valid.model_copy(update={"plugins": _packages(valid.plugins, mistakes)})
    valid = resolved(valid, valid.plugins, "", mistakes)
    mistakes += _overlays(valid)
    rooms = valid.experiment.model_copy(update={"rooms": valid.experiment.named()})
    of_run = of_picture(valid) if valid.image and not mistakes else rooms
    valid = valid.model_copy(update={"experiment": of_run})
    mistakes += [each for each in contradictions(valid) if not any(_overlap(each.key, key) for key in wrong)]
    if not rooms_named:
        mistakes = [each for each in mistakes if each.key != "experiment.rooms"]
    if mistakes:
        lines = [str(mistake) for mistake in mistakes]
        heading = f"{len(lines)} mistakes:\n  " if len(lines) > 1 else ""
        code = mistakes[0].code if len(mistakes) == 1 else "E-CONFIG"
        raise InputError("config", heading + "\n  ".join(lines), code=code)
    return valid


def _overlays(config: Config) -> Iterator[Mistake]:
    """What is wrong with the keys that variants, placements and targets change; such changes are taken back."""
    kinds: tuple[tuple[str, type[Section], Callable[[str], Section]], ...] = (
        ("variants", MatchingConfig, config.matching_of),
        ("placements", GenerationConfig, config.generation_of),
        ("targets", TaskConfig, config.task_of),
    )
    for section, model, read in kinds:
        entries = getattr(config.experiment, section)
        for name, entry in list(entries.items()):
            key, changes = f"experiment.{section}.{name}", entry
            if isinstance(entry, Target):
                key, changes = f"{key}.options", entry.options
            yield from truths(changes, model, key)
            try:
                read(name)
                continue
            except ValidationError as error:
                yield from mistakes_of(model, error, f"{key}.")
            except InputError as error:
                yield Mistake.of(error)
            entries[name] = entry.model_copy(update={"options": {}}) if isinstance(entry, Target) else {}


def of_picture(config: Config) -> ExperimentConfig:
    """The experiment whose one scene is the picture of `image`, found by `inputs estimate`, without policies."""
    name = scene_of(Path(config.image).with_suffix(""))
    name = f"{name}-photo" if name in config.room_files() else name
    only = {"rooms": [name], "inputs": {name: Input(image=config.image)}}
    only |= {key: {} for key in ("targets", "policies", "pools", "protocols")}
    return config.experiment.model_copy(update=only)


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
