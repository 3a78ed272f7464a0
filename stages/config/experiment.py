"""Config section `experiment`: which cells of the paper's tables this run computes."""

import fnmatch
from itertools import chain
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from stages.config.inputs import Input
from stages.contracts.section import Rank, Section, Seed
from stages.contracts.training_sets import DRAWN, RANDOMISED, RULES, SET_NAME, drawn_role, read_set

TrainingSet = Annotated[str, Field(pattern=f"^{SET_NAME}$")]


class TaskTarget(Section):
    """A row of the policy experiment: a task, the object it is about, and what differs from the experiment's own."""

    task: str | None = Field(None, description="which task this is: door, drawer, ... or yours; null: as it is named")
    scene: str = Field("room_3", description="room of the object, one of `rooms`")
    object: str = Field("hanging_cabinet_1", description="its id in that room's objects.json")
    options: dict[str, Any] = Field({}, description="keys of section `task` that differ here, e.g. {max_steps: 200}")
    assets: str | None = Field(
        None,
        description="a committed file of the row's assets (docs/policies.md), checked against the library; null: "
        "chosen anew",
    )
    assets_of: str | None = Field(
        None,
        description="another row whose object, options, assets and demonstrations this one shares: only its policies "
        "are its own",
    )
    training_sets: list[TrainingSet] | None = Field(None, description="null: those of the experiment; so for the rest")
    runs: list[str] | None = Field(None, min_length=1)
    seeds: list[Seed] | None = Field(None, min_length=1)
    episodes: int | None = Field(None, ge=1)


class TaskPlan(NamedTuple):
    """A row of the policy experiment with nothing left open; `task`: name of the implementation."""

    task: str
    target: TaskTarget
    training_sets: list[TrainingSet]
    runs: list[str]
    seeds: list[int]
    episodes: int


class Protocol(Section):
    """Rooms met otherwise than for Table 2: rows of its companion `table2_robustness.csv`."""

    seeds: list[Seed] = Field(
        [0],
        min_length=1,
        description="Every room is met once with each: the seed of the depth noise and of what is drawn below.",
    )
    layout: Literal["recipe", "drawn"] = Field(
        "recipe", description="drawn: places, camera, colours and models of the room are drawn by chance."
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
    def pictured(self) -> bool:
        """Whether its rooms need pictures of their own."""
        return self.layout == "drawn" or self.finish == "other"


class Meeting(NamedTuple):
    """A room as one job meets it; `name` is '' and `seed` None where no protocol is followed."""

    room: str
    name: str
    seed: int | None
    protocol: Protocol


def _as_written(schema: dict[str, Any]) -> None:
    """What may stand under `inputs`, for editors."""
    one = {"anyOf": [{"type": "string"}, schema.pop("additionalProperties")]}
    text = {"type": "string"}
    schema.pop("type")
    schema["anyOf"] = [{"type": "object", "additionalProperties": one}, text, {"type": "array", "items": text}]


class ExperimentConfig(Section):
    """Rooms, variants and policies of this run."""

    rooms: list[str] = Field(
        ["room_1", "room_2", "room_3"],
        min_length=1,
        description="Scenes to reconstruct: room_1 ... room_8 (Table 2), rooms of your own, or names from `inputs`, "
        'where * stands for anything: ["*"] is all of them.',
    )
    room_files: list[str] = Field(
        [], description="Rooms of your own: YAML files as in stages/scenes/rooms (docs/scenes.md), named by their stem."
    )
    inputs: dict[str, Input] = Field(
        {},
        json_schema_extra=_as_written,
        description="Your own scenes: name -> input folder (docs/scenes.md), or what a row of a table says; or a table "
        "(CSV), a folder of input folders, or a list of these (docs/your-data.md). They are reconstructed like the "
        "rooms, but not scored: there is no truth.",
    )
    variants: dict[str, dict[str, Any]] = Field(
        {"b": {}},
        min_length=1,
        description="Variants of matching that exist side by side (the rows of Table 2): name -> keys of `matching` "
        "that differ. The paper's (b) lets the patch encoder choose model and orientation.",
    )
    placements: dict[str, dict[str, Any]] = Field(
        {}, description="How variants are placed, where that differs: name of a variant -> keys of `generation`."
    )
    protocols: dict[str, Protocol] = Field(
        {},
        description="Rooms met otherwise, for table2_robustness: name -> {seeds, layout: drawn, finish: other, "
        "unknown: true, scale_error: false, variants}, as far as they differ (docs/scenes.md).",
    )
    policy_variant: str = Field("b", description="The variant whose cousins the policy experiment uses.")
    tasks: dict[str, TaskTarget] = Field(
        {
            "door": TaskTarget(scene="room_3", object="hanging_cabinet_1"),
            "door_handle": TaskTarget(assets_of="door", runs=["lite_handle"]),
        },
        description="Tasks of the policy experiment (Table 3), by names that paths and tables use. One task may stand "
        "here twice, e.g. as `door` and, with other `options`, as `my_door: {task: door, ...}`. A row goes "
        "with the one whose assets it shares: `door: null` removes `door_handle` as well.",
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
    runs: list[str] = Field(
        ["lite"],
        description="Hyper-parameter sets to train, from `training.runs`: each has rows of its own in the tables, and "
        "the first is what the others are compared with.",
    )
    best_runs: int = Field(
        2,
        ge=1,
        description="How many of `runs` are trained with all seeds, per task and training set: if there are more, "
        "each is trained with the first seed and tried on the twin, and the best are chosen (paper: 2). Those are "
        "pooled in the tables, so all must be one kind of policy.",
    )
    seeds: list[Seed] = Field([0], description="Training seeds. The paper: best two hyper-parameter sets x 3 seeds.")
    in_scene: int = Field(
        2,
        ge=0,
        description="In how many ranks' generated scenes every task is demonstrated once, with a film (the paper's "
        "Figure 7); 0: in none.",
    )

    def named(self) -> list[str]:
        """`rooms`, with names from `inputs` in the place of patterns, each once."""
        plain = [room for room in self.rooms if "*" not in room]
        matched = [fnmatch.filter(self.inputs, room) or [room] for room in self.rooms if "*" in room]
        return [*plain, *(name for name in dict.fromkeys(chain(*matched)) if name not in plain)]

    @property
    def pictures(self) -> list[str]:
        """Pictures of this run that networks look at."""
        given = [self.inputs[room] for room in self.rooms if room in self.inputs]
        return [one.image for one in given if one.alone]

    def meeting(self, scene: str) -> Meeting:
        """What a scene is: `<room>`, or `<room>.<protocol>.<seed>`."""
        room, *met = scene.split(".")
        if not met:
            return Meeting(room, "", None, Protocol())
        return Meeting(room, met[0], int(met[1]), self.protocols[met[0]])

    def met(self) -> dict[str, list[str]]:
        """The scenes of all protocols, each with its variants."""
        scored = [room for room in self.rooms if room not in self.inputs]
        return {
            f"{room}.{name}.{seed}": protocol.variants or list(self.variants)
            for name, protocol in self.protocols.items()
            for seed in protocol.seeds
            for room in scored
        }

    def source(self, name: str) -> str:
        """The row whose object, options, assets and demonstrations a row uses: that of its `assets_of`, or itself."""
        shared = self.tasks[name].assets_of
        return shared if shared in self.tasks else name

    @property
    def sources(self) -> list[str]:
        """The rows that have assets and demonstrations of their own."""
        return [name for name in self.tasks if self.source(name) == name]

    def sharing(self, source: str) -> list[str]:
        """The rows that use the assets and demonstrations of a row, itself included."""
        return [name for name in self.tasks if self.source(name) == source]

    def plan(self, name: str) -> TaskPlan:
        """What is asked of one task."""
        own, source = self.tasks[name], self.source(name)
        target = self.tasks[source]
        return TaskPlan(
            task=target.task or source,
            target=target,
            training_sets=self.training_sets if own.training_sets is None else own.training_sets,
            runs=self.runs if own.runs is None else own.runs,
            seeds=self.seeds if own.seeds is None else own.seeds,
            episodes=self.episodes if target.episodes is None else target.episodes,
        )

    def chooses(self, name: str) -> bool:
        """Whether a task has more hyper-parameter sets than are trained with all seeds."""
        return len(self.plan(name).runs) > self.best_runs

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

    def share(self, task: str, training_set: str) -> int:
        """Demonstrations that each store gives to a training set."""
        return self.plan(task).episodes // read_set(training_set).count

    def sets_of(self, task: str) -> list[str]:
        """The training sets of all rows that use a row's demonstrations."""
        return sorted({name for row in self.sharing(task) for name in self.plan(row).training_sets})

    def trained_roles(self, task: str) -> list[str]:
        """Roles on which a task's demonstrations are collected; none where they are another row's."""
        return sorted({role for name in self.sets_of(task) for role in self.roles_of(task, name)})

    def roles_of(self, task: str, training_set: str) -> list[str]:
        """`roles` of all seeds of the rows that use a row's demonstrations for a training set."""
        plans = [plan for plan in map(self.plan, self.sharing(task)) if training_set in plan.training_sets]
        seeds = sorted({seed for plan in plans for seed in plan.seeds})
        return list(dict.fromkeys(role for seed in seeds for role in self.roles(training_set, seed)))

    def episodes_of(self, task: str, role: str) -> int:
        """Demonstrations to collect for a role: the largest share that any training set of any row asks of it."""
        return max((self.share(task, n) for n in self.sets_of(task) if role in self.roles_of(task, n)), default=0)
