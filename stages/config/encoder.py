"""Config section `encoder`: training the patch encoder `patchnet` (docs/matching.md)."""

from typing import Literal

from pydantic import Field

from stages.contracts.section import Count, Rank, Section

HELD_OUT = ["bed", "chair", "mug", "plant_pot", "television"]


class PairOptions(Section):
    """The models and pictures that it is trained on."""

    held_out: list[str] = Field(HELD_OUT, description="Categories that it never sees, to know how it does on new ones.")
    models: Rank = Field(20, description="Procedural models per other category, none of the library's.")
    assemblies: Count = Field(100, description="Models put together of random solids.")
    views: int = Field(12, ge=2, description="Pictures per model, evenly round it, each beside a snapshot.")


class EncoderTrainingOptions(Section):
    """The optimisation."""

    steps: Rank = Field(1200, description="AdamW updates.")
    batch_models: Rank = Field(8, description="Models per batch ...")
    batch_views: Rank = Field(4, description="... and views of each, which must not be taken for each other.")
    learning_rate: float = Field(1e-3, gt=0, description="Peak: reached after `warm_up` steps, kept for `flat` ...")
    warm_up: Rank = Field(50, description="... times as many; then it falls with the root of the steps,")
    flat: float = Field(6, ge=1, description="whatever their number: a run can be made longer.")
    weight_decay: float = Field(0.05, ge=0, description="Of AdamW.")
    temperature: float = Field(0.07, gt=0, description="Of both losses.")
    owner: float = Field(0.5, ge=0, description="Weight of the second loss: patches lie nearest to the right snapshot.")
    precision: Literal["bf16", "fp32"] = Field("bf16", description="Of the network's passes.")
    save_every: Rank = Field(25, description="Steps between states that an interrupted run resumes from.")


class EncoderConfig(EncoderTrainingOptions, PairOptions):
    """The training of the patch encoder `patchnet`, by `snakemake encoder` alone: its weights are shipped."""

    shards: Rank = Field(1, description="Jobs that the pictures are cut into.")
