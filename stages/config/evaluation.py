"""Config section `evaluation`: rollouts of policies and scores of scenes (paper B.1, B.3)."""

from typing import ClassVar, Literal

from pydantic import Field

from roomkin.stages.contracts.section import NotNegative, Section

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
