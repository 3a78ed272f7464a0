"""Sections `evaluation`, rollouts of policies and scores of scenes (paper B.1, B.3), and `tables`, made of them."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from roomkin.stages.contracts.section import NotNegative, Section, Seed

USUAL = "usual"  # how tables call what section `evaluation` says, beside its `conditions`


class SceneOptions(Section):
    """How a test asset is shown."""

    vary_scale: bool = Field(
        False, description="rescale the test asset at random as in the demonstrations (official: no)"
    )
    own_size: bool = Field(False, description="the test asset at its own size, not in the box of the task's object")
    simulator: str = Field(
        "maniskill",
        json_schema_extra={"kind": "simulators"},
        description="maniskill: that of the demonstrations; mujoco: another, with physics, contacts, controller and "
        "depth of its own, in the place of the paper's real robot; door and drawer",
    )
    robot_init_noise: tuple[NotNegative, NotNegative] | None = Field(
        None, description="the robot stands within so many metres and degrees of its place; null: as in `task`"
    )


class SensingOptions(SceneOptions):
    """How a policy sees a test asset; the scripted skill looks at nothing."""

    depth_noise: bool = Field(False, description="depth has the noise of a depth camera (Nguyen et al. 2012)")
    camera_error: tuple[NotNegative, NotNegative] = Field(
        (0.0, 0.0), description="metres and degrees by which the camera is off the pose that policies assume"
    )


class ActingOptions(SensingOptions):
    """How a policy acts."""

    checkpoint: Literal["best", "last", "rollouts"] = Field(
        "best",
        description="best: as `training` selected; rollouts: of the `num_checkpoints` of its config, the one with "
        "most successes in its selection rollouts on the twin (the paper's way)",
    )
    action: Literal["sample", "sharpened", "most_likely"] = Field(
        "sharpened",
        description="mode of the mixture to act by: drawn by its weight (official), by the square of its weight, or "
        "the heaviest; docs/results/policies.md has figures",
    )
    # Environments that share a forward pass of the policy
    envs: ClassVar[int] = 4


class SelectionOptions(ActingOptions):
    """Rollouts that select checkpoints and policy configs."""

    selection_rollouts: int = Field(
        20,
        ge=1,
        description="episodes per checkpoint on the twin, from states that no test uses; they choose "
        "checkpoints (`checkpoint: rollouts`) and, of more than `experiment.best_configs`, policy configs",
    )


class SkillOptions(SceneOptions):
    """The test assets and initial states of policies, and of the scripted skill beside them."""

    test_assets: list[str] = Field(
        ["twin", "cousin_2", "cousin_6", "dissimilar", "trained"],
        min_length=1,
        description="roles to roll out on; paper: the twin, the 2nd and 6th cousin (held out), a dissimilar asset; "
        "trained: the very assets that the policy was trained on, the rollouts shared evenly: the first gate",
    )
    rollouts: int = Field(
        16, ge=1, description="episodes per test asset, the same initial states for all policies; paper: 100"
    )
    twin_rollouts: int | None = Field(
        None,
        ge=1,
        description="episodes on the twin, first those of `rollouts`: 60 can show that two sets do as well, 25 cannot; "
        "null: as many as on the others",
    )
    split: Literal["validation", "test"] = Field(
        "test",
        description="the unseen assets to roll out on: validation (every choice is made on these) or test (looked at "
        "once, at the end)",
    )
    assets: int = Field(
        24, ge=0, description="how many assets of the split, of families apart from all training; 0: none"
    )
    asset_rollouts: int = Field(
        2, ge=1, description="episodes on each of them, the same initial states for all policies"
    )


class RolloutOptions(ActingOptions, SkillOptions):
    """Rollouts that are counted."""


class EvaluationConfig(SelectionOptions, RolloutOptions):
    """How policies are rolled out."""

    conditions: dict[str, SensingOptions] = Field(
        {},
        description="further conditions of testing, by name, e.g. {mujoco: {simulator: mujoco}}: the target "
        "`conditions` rolls every policy out under each and compares success there with success here",
    )

    def episodes(self) -> int:
        """How many episodes one policy is rolled out for."""
        more = (self.twin_rollouts or self.rollouts) - self.rollouts
        return len(self.test_assets) * self.rollouts + more + self.assets * self.asset_rollouts

    def under(self, condition: str) -> "EvaluationConfig":
        """The section with what one of the conditions changes."""
        differs = self.conditions[condition]
        return self.model_copy(update={name: getattr(differs, name) for name in differs.model_fields_set})


class TablesConfig(Section):
    """How rows of `evaluation` become the paper's tables."""

    scenes: dict[str, Annotated[int, Field(ge=1, le=8)]] = Field(
        {f"room_{k}": k for k in range(1, 9)},
        description="Scenes of Table 2 and the published scene (1 ... 8, in the paper's order) shown beside each. "
        "Every one gets its rows, 'not run' where nothing was computed.",
    )
    variants: dict[str, Literal["a", "b", "c", "d"]] = Field(
        {"a": "a", "b": "b", "c": "c", "d": "d"},
        description="Variants of Table 2 and the published variant (a-d) shown beside each.",
    )
    # Level of every interval.
    confidence: ClassVar[float] = 0.95
    bootstrap_samples: int = Field(
        10_000,
        ge=100,
        description="Resamples (of assets, initial states and runs) behind the intervals of policies.",
    )
    # Seed of the resamples.
    seed: ClassVar[Seed] = 0
    # Largest width of a picture in the report page, pixels.
    picture_width: ClassVar[int] = 1100
    # WebP quality of the pictures in the report page.
    picture_quality: ClassVar[int] = 80


class PolicyAbout(Section):
    """A policy of the experiment.

    best: how many of its configs are chosen, to be pooled; None: there is one. targets: what it opens.
    """

    configs: list[str]
    best: int | None = None
    targets: list[str]


class MethodTables(TablesConfig):
    """Policies and pools of targets by their names, as far as they are known."""

    policies: dict[str, PolicyAbout] = {}
    pools: dict[str, list[str]] = {}


class PolicyTables(MethodTables):
    """Facts about the policies for the tables, as far as they are known.

    kinds: policy -> its kind in words. papers: policies of the paper's kind. encoder: that whose features give the
    distance from the twin. sensing: how policies see the test assets. starts: per target, how far the robot starts off
    its place before the handle, along and up, metres.
    """

    kinds: dict[str, str] = {}
    papers: list[str] = []
    encoder: str = ""
    sensing: SensingOptions | None = None
    starts: list[tuple[float, float]] = []
