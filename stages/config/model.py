"""The whole of config.yaml: one typed section per stage."""

from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator

from stages.config.assets import AssetsConfig
from stages.config.base import Section
from stages.config.containers import ContainersConfig
from stages.config.demonstrations import DemonstrationsConfig
from stages.config.evaluation import EvaluationConfig
from stages.config.experiment import ExperimentConfig
from stages.config.extraction import ExtractionConfig
from stages.config.generation import GenerationConfig
from stages.config.matching import MatchingConfig
from stages.config.names import resolved
from stages.config.replaced import Replaced
from stages.config.scenes import ScenesConfig
from stages.config.suggest import explain
from stages.config.tables import TablesConfig
from stages.config.task import TaskConfig
from stages.config.training import TrainingConfig
from stages.contracts.errors import InputError
from stages.plugins import find


class Config(Section):
    """Config of the workflow. What is not set keeps the default given here."""

    seed: int = Field(
        0, ge=0, description="Seed of everything random: library, rooms, noise, demonstrations, rollouts."
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
    extraction: ExtractionConfig = Field(ExtractionConfig(), description="From image to objects in space (A.2, A.7).")
    matching: MatchingConfig = Field(MatchingConfig(), description="Digital cousins of every object (A.6, A.7, B.1).")
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
        "e.g. {matching: {match: {command: python mine.py, code: [mine.py]}}} (docs/swapping.md).",
    )
    containers: ContainersConfig = Field(ContainersConfig(), description="Images of the rules, for `--sdm apptainer`.")

    @model_validator(mode="after")
    def _consistent(self) -> "Config":
        experiment = self.experiment
        known = [f"room_{k}" for k in range(1, 9)] + list(experiment.inputs)
        for room in experiment.rooms:
            if room not in known:
                raise ValueError(f"experiment.rooms: unknown scene '{room}'; known: {', '.join(known)}")
        if experiment.policy_variant not in experiment.variants:
            raise ValueError(
                f"experiment.policy_variant: '{experiment.policy_variant}' is not one of experiment.variants"
            )
        for task, target in experiment.tasks.items():
            if target.scene not in experiment.rooms:
                raise ValueError(f"experiment.tasks.{task}.scene: '{target.scene}' is not one of experiment.rooms")
        for run in experiment.runs:
            if run not in self.training.runs:
                raise ValueError(
                    f"experiment.runs: '{run}' is not one of training.runs: {', '.join(self.training.runs)}"
                )
        for training_set in experiment.training_sets:
            experiment.roles(training_set)
        for name in experiment.variants:
            self.matching_of(name)
        return self

    def matching_of(self, variant: str) -> MatchingConfig:
        """The matching options of one variant."""
        merged = MatchingConfig.model_validate(self.matching.model_dump() | self.experiment.variants[variant])
        return resolved(merged, self.plugins, f"experiment.variants.{variant}")

    def implementation(self, kind: str, name: str) -> str:
        """The name by which a stage loads an implementation."""
        return find(kind, name, self.plugins)


def load(config: dict[str, Any]) -> Config:
    """Validate a merged config.

    Raises:
        InputError: names the section and key; an unknown key comes with the nearest known one.
    """
    try:
        valid = Config.model_validate(config)
    except ValidationError as error:
        raise InputError("config", explain(Config, error), "see config/README.md") from None
    for task in valid.experiment.tasks:
        find("tasks", task, valid.plugins, f"experiment.tasks.{task}")
    valid = resolved(valid, valid.plugins, "")
    for stage, commands in valid.stages.items():
        for verb, own in commands.items():
            for name in own.code:
                if not Path(name).exists():
                    raise InputError("config", f"stages.{stage}.{verb}.code: no file or folder {name}.", "correct it")
    return valid
