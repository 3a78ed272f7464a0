"""Config section `experiment`: which cells of the paper's tables this run computes."""

from typing import Any, Literal

from pydantic import Field

from stages.config.base import Count, Rank, Section


class TaskTarget(Section):
    """The object that the policy experiment opens."""

    scene: str = Field("room_3", description="room of the object, one of `rooms`")
    object: str = Field("hanging_cabinet_1", description="its id in that room's objects.json")


class ExperimentConfig(Section):
    """Rooms, variants and policies of this run."""

    rooms: list[str] = Field(
        ["room_1", "room_2", "room_3"],
        min_length=1,
        description="Scenes to reconstruct: room_1 ... room_8 (Table 2), rooms of your own, or names from `inputs`.",
    )
    room_files: list[str] = Field(
        [], description="Rooms of your own: YAML files as in stages/scenes/rooms (docs/scenes.md), named by their stem."
    )
    inputs: dict[str, str] = Field(
        {},
        description="Your own scenes: name -> folder with rgb.png, camera.json, depth.npz, masks.png and "
        "annotations.json (docs/scenes.md). They are reconstructed like the rooms, but not scored: there is no truth.",
    )
    variants: dict[str, dict[str, Any]] = Field(
        {"b": {}},
        min_length=1,
        description="Variants of matching that exist side by side (the rows of Table 2): name -> keys of `matching` "
        "that differ. The paper's (b) lets the patch encoder choose model and orientation.",
    )
    policy_variant: str = Field("b", description="The variant whose cousins the policy experiment uses.")
    tasks: dict[str, TaskTarget] = Field(
        {"door": TaskTarget(scene="room_3", object="hanging_cabinet_1")},
        description="Tasks of the policy experiment (Table 3) and the object each one opens.",
    )
    training_sets: list[Literal["twin", "cousins_2", "cousins_4", "cousins_8", "all"]] = Field(
        ["twin", "cousins_4"],
        description="Training sets to compare; []: no policies. cousins_n: the n nearest cousins not held out; "
        "all: every ranked cousin not held out.",
    )
    held_out: list[Rank] = Field([2, 6], description="Cousins kept out of every training set (paper: 2nd and 6th).")
    cousins: int = Field(10, ge=1, description="How many cousins the policy experiment knows.")
    episodes: int = Field(
        160, ge=1, description="Demonstrations in every training set, shared evenly by its assets so that sets compare."
    )
    runs: list[str] = Field(["lite"], description="Hyper-parameter sets to train, from `training.runs`.")
    seeds: list[Count] = Field([0], description="Training seeds. The paper: best two hyper-parameter sets x 3 seeds.")
    training_threads: int = Field(
        1, ge=1, description="CPU threads per training job; 1 lets two policies train at once."
    )

    def roles(self, training_set: str) -> list[str]:
        """Roles (twin, cousin_i) whose demonstrations make up a training set, in order of rank."""
        if training_set == "twin":
            return ["twin"]
        return [f"cousin_{rank}" for rank in self.training_ranks[: self.size_of(training_set)]]

    @property
    def training_ranks(self) -> list[int]:
        """Cousins that training may use."""
        return [rank for rank in range(1, self.cousins + 1) if rank not in self.held_out]

    def size_of(self, training_set: str) -> int:
        """Cousins that a training set asks for; the twin's asks for none."""
        if training_set == "twin":
            return 0
        return len(self.training_ranks) if training_set == "all" else int(training_set.removeprefix("cousins_"))

    def share(self, training_set: str) -> int:
        """Demonstrations that each asset gives to a training set (rounded up)."""
        return -(-self.episodes // len(self.roles(training_set)))

    def episodes_of(self, role: str) -> int:
        """Demonstrations to collect for a role: the largest share that any training set asks of it."""
        return max((self.share(name) for name in self.training_sets if role in self.roles(name)), default=0)
