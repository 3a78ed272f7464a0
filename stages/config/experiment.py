"""Config section `experiment`: which cells of the paper's tables this run computes."""

import fnmatch
from itertools import chain
from typing import Any, Literal, NamedTuple

from pydantic import Field, ValidationInfo, field_validator

from roomkin.stages.config.pictures import Picture, as_written
from roomkin.stages.config.targets import Cell, PolicyChoice, PolicyPlan, RoomTarget, TrainingSet
from roomkin.stages.contracts.policy_config import DRAWN, RANDOMISED, RULES, drawn_role, read_set
from roomkin.stages.contracts.section import Rank, Section, Seed


class Perturbation(Section):
    """The rooms of Table 2, changed: rows of its companion `table2_robustness.csv`."""

    seeds: list[Seed] = Field(
        [0],
        min_length=1,
        description="Every room is tested once with each: the seed of the depth noise and of what is drawn below.",
    )
    layout: Literal["recipe", "drawn"] = Field(
        "recipe", description="drawn: places, camera, colors and models of the room are drawn by chance."
    )
    finish: Literal["library", "other"] = Field(
        "library",
        description="other: the room's models are painted, lit and scaled otherwise than the library's snapshots.",
    )
    unknown: bool = Field(
        False,
        description="The true models of the room, and their whole families, are taken out of the library at matching.",
    )
    scale_error: bool = Field(True, description="false: no global factor on the depth (extraction.noise.scale: 0).")
    variants: list[str] | None = Field(None, min_length=1, description="null: all of `variants`.")

    @property
    def own_pictures(self) -> bool:
        """Whether its rooms need pictures of their own."""
        return self.layout == "drawn" or self.finish == "other"


class Scene(NamedTuple):
    """The parts of a scene's name; `protocol`, the name of a perturbation, is '' and `seed` None if it has none."""

    room: str
    protocol: str
    seed: int | None
    options: Perturbation


class ExperimentConfig(Section):
    """Rooms, variants and policies of this run."""

    rooms: list[str] = Field(
        ["room_1", "room_2", "room_3"],
        min_length=1,
        description="Scenes to reconstruct: room_1 ... room_8 (Table 2), rooms of your own, or names from `inputs`, "
        'where * stands for anything: ["*"] is all of them.',
    )
    room_files: list[str] = Field(
        [],
        description="Rooms of your own: YAML files (docs/scenes.md), named by their stem.",
    )
    inputs: dict[str, Picture] = Field(
        {},
        json_schema_extra=as_written,
        description="Your own scenes: name -> input folder (docs/scenes.md), or what a row of a table says; or a table "
        "(CSV), a folder of input folders, or a list of these (docs/your-data.md). They are reconstructed like the "
        "rooms, but not scored: there is no truth.",
    )
    variants: dict[str, dict[str, Any]] = Field(
        {"default": {}},
        min_length=1,
        description="Variants of matching that exist side by side (the rows of Table 2): name -> keys of `matching` "
        "that differ. `default` is none of the paper's, whose (b) lets the patch encoder choose model and orientation.",
    )
    placements: dict[str, dict[str, Any]] = Field(
        {}, description="How variants are placed, where that differs: name of a variant -> keys of `generation`."
    )
    protocols: dict[str, Perturbation] = Field(
        {},
        description="Variants of the rooms, for table2_robustness: name -> {seeds, layout: drawn, finish: other, "
        "unknown: true, scale_error: false, variants}, as far as they differ (docs/scenes.md).",
    )
    policy_variant: str = Field("default", description="The variant whose cousins the policy experiment uses.")
    targets: dict[str, RoomTarget] = Field(
        {"door": RoomTarget(room="room_3", object="hanging_cabinet_1")},
        description="What is opened (Table 3), by names that paths and tables use. Demonstrations belong to a target; "
        "all policies share them.",
    )
    policies: dict[str, PolicyChoice] = Field(
        {"lite": PolicyChoice(), "lite_handle": PolicyChoice()},
        description="What opens it: every policy is trained for every target and rolled out there, unless it names "
        "some. The first of a target is what its others are compared with.",
    )
    pools: dict[str, list[str]] = Field(
        {},
        description="Targets that are one row of the tables, by its name, e.g. {door: [door_1, door_2]}: one task with "
        "the same options, for several objects.",
    )
    training_sets: list[TrainingSet] = Field(
        ["twin", "cousins_4"],
        description="Training sets to compare; []: no policies. twin: the object's own model; cousins_n: the n nearest "
        "cousins not held out; random_n: n assets that open alike, drawn by chance; cover_n: n drawn by chance that "
        "are spread over widths of fronts and heights of handles; all: every asset of the object's three nearest "
        "categories that may be trained on. Each may end in _randomised (twin_randomised): stretched, friction and "
        "mass drawn anew in every attempt.",
    )
    draws: int = Field(
        5,
        ge=1,
        description="How often random_n and cover_n are drawn: the policies of seed s learn from draw s modulo this; "
        "1: all of them from the same assets.",
    )
    held_out: list[Rank] = Field([2, 6], description="Cousins kept out of every training set (paper: 2nd and 6th).")
    cousins: int = Field(10, ge=1, description="How many cousins the policy experiment knows.")
    episodes: int = Field(
        160,
        ge=1,
        description="Demonstrations in every training set, shared evenly by its assets so that sets compare: a "
        "multiple of their numbers.",
    )
    best_configs: int = Field(
        2,
        ge=1,
        description="Of a policy with more configs than this, how many are trained with all seeds: each is trained "
        "with the first seed and tried on the twin, per target and training set, and the best are chosen (paper: 2). "
        "Those are pooled in the tables.",
    )
    seeds: list[Seed] = Field([0], description="Training seeds. The paper: best two hyper-parameter sets x 3 seeds.")
    in_scene: int = Field(
        2,
        ge=0,
        description="In how many ranks' generated scenes every target is demonstrated once, with a film (the paper's "
        "Figure 7); 0: in none.",
    )

    @field_validator("targets", "policies")
    @classmethod
    def _default_first(cls, given: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """Those of config.yaml first: Snakemake puts what a further file adds before them."""
        default = cls.model_fields[str(info.field_name)].default
        return {name: given[name] for name in (*default, *given) if name in given}

    @property
    def frames(self) -> list[str]:
        """Scenes whose input folders the workflow makes of frames with depth and masks."""
        return [name for name, one in self.inputs.items() if not one.folder and not one.alone and one.masks]

    @property
    def views(self) -> list[str]:
        """Scenes whose input folders the workflow makes of frames with depth, and whose things it finds itself."""
        made = {name: one for name, one in self.inputs.items() if not one.folder and not one.masks}
        return [name for name, one in made.items() if one.measured or not one.alone]

    @property
    def measured(self) -> list[str]:
        """Those of them whose depth a network measures."""
        return [name for name, one in self.inputs.items() if one.measured]

    @property
    def photographs(self) -> list[str]:
        """Scenes whose input folders the workflow draws of pictures without depth."""
        return [name for name, one in self.inputs.items() if one.alone and not one.drawing and not one.measured]

    @property
    def drawn(self) -> list[str]:
        """Scenes whose input folders the workflow makes of pictures without depth and what was drawn into them."""
        return [name for name, one in self.inputs.items() if one.alone and one.drawing]

    @property
    def pictures(self) -> list[str]:
        """Pictures of this run that networks look at."""
        given = [self.inputs[room] for room in self.rooms if room in self.inputs]
        return [one.image for one in given if one.alone and not one.drawing]

    def named(self) -> list[str]:
        """`rooms`, with names from `inputs` in the place of patterns, each once."""
        plain = [room for room in self.rooms if "*" not in room]
        matched = [fnmatch.filter(self.inputs, room) or [room] for room in self.rooms if "*" in room]
        return [*plain, *(name for name in dict.fromkeys(chain(*matched)) if name not in plain)]

    def scene(self, name: str) -> Scene:
        """A scene by its name: `<room>`, `<room>.<protocol>.<seed>`, or that of a picture of the user's."""
        room, _, perturbed = name.partition(".")
        if not perturbed:
            return Scene(room, "", None, Perturbation())
        protocol, _, seed = perturbed.rpartition(".")
        return Scene(room, protocol, int(seed), self.protocols[protocol])

    def picture_of(self, scene: str) -> str:
        """The scene in whose picture a scene is seen: only some perturbations take their own."""
        return scene if self.scene(scene).options.own_pictures else self.scene(scene).room

    def input_folder(self, scene: str) -> str:
        """The folder of a scene's picture: the user's own, or where the room is rendered."""
        own = self.inputs.get(scene)
        return own.place(scene) if own else f"results/scenes/{self.picture_of(scene)}/input"

    def perturbed_scenes(self) -> dict[str, list[str]]:
        """The scenes of all perturbed rooms, each with its variants."""
        scored = [room for room in self.rooms if room not in self.inputs]
        drawn = [(f"{name}.{seed}", each) for name, each in self.protocols.items() for seed in each.seeds]
        return {f"{room}.{end}": each.variants or list(self.variants) for end, each in drawn for room in scored}

    def task(self, target: str) -> str:
        """Which task a target is."""
        return self.targets[target].task or target

    def plan(self, policy: str) -> PolicyPlan:
        """The targets, training sets and seeds of a policy; the pools among its targets are resolved."""
        own = self.policies[policy]
        named = list(self.targets) if own.targets is None else own.targets
        return PolicyPlan(
            targets=list(dict.fromkeys(chain(*(self.pools.get(name, [name]) for name in named)))),
            configs=[policy] if own.configs is None else own.configs,
            training_sets=self.training_sets if own.training_sets is None else own.training_sets,
            seeds=self.seeds if own.seeds is None else own.seeds,
        )

    def plans(self, target: str) -> dict[str, PolicyPlan]:
        """The policies that open a target."""
        plans = {policy: self.plan(policy) for policy in self.policies}
        return {policy: plan for policy, plan in plans.items() if target in plan.targets}

    @property
    def cells(self) -> list[Cell]:
        """All cells of the policy experiment, target by target."""
        plans = [(target, *plan) for target in self.targets for plan in self.plans(target).items()]
        return [Cell(target, policy, name) for target, policy, plan in plans for name in plan.training_sets]

    def needs_choice(self, policy: str) -> bool:
        """Whether a policy has more hyper-parameter sets than are trained with all seeds."""
        return len(self.plan(policy).configs) > self.best_configs

    def roles(self, training_set: str, seed: int) -> list[str]:
        """Roles whose demonstrations the policies of a training set and seed learn from, in order; one store each.

        They are twin, cousin_i, random_i, cover_i, all; of a set that is randomised they end as it does.
        """
        rule, count, randomised = read_set(training_set)
        if rule in DRAWN:
            roles = [drawn_role(rule, seed % self.draws, place) for place in range(count)]
        elif rule in RULES:
            roles = [f"{RULES[rule]}_{rank}" for rank in self.training_ranks[:count]]
        else:
            roles = [rule]
        return [role + RANDOMISED * randomised for role in roles]

    @property
    def training_ranks(self) -> list[int]:
        """Cousins that training may use."""
        return [rank for rank in range(1, self.cousins + 1) if rank not in self.held_out]

    def share(self, target: str, training_set: str) -> int:
        """Demonstrations that each store gives to a training set."""
        return (self.targets[target].episodes or self.episodes) // read_set(training_set).size

    def sets_of(self, target: str) -> list[str]:
        """The training sets of all policies that open a target."""
        return sorted({name for plan in self.plans(target).values() for name in plan.training_sets})

    def list_trained_roles(self, target: str) -> list[str]:
        """Roles on which a target's demonstrations are collected."""
        return sorted({role for name in self.sets_of(target) for role in self.roles_of(target, name)})

    def roles_of(self, target: str, training_set: str) -> list[str]:
        """`roles` of all seeds of the policies that open a target after a training set."""
        plans = [plan for plan in self.plans(target).values() if training_set in plan.training_sets]
        seeds = sorted({seed for plan in plans for seed in plan.seeds})
        return list(dict.fromkeys(role for seed in seeds for role in self.roles(training_set, seed)))

    def episodes_of(self, target: str, role: str) -> int:
        """Demonstrations to collect for a role: the largest share that any training set asks of it."""
        shares = [self.share(target, name) for name in self.sets_of(target) if role in self.roles_of(target, name)]
        return max(shares, default=0)
