"""Config section `evaluation`: rollouts of policies and scores of scenes (paper B.1, B.3)."""

from typing import Literal

from pydantic import Field

from stages.config.base import Section


class EvaluationConfig(Section):
    """How policies are rolled out."""

    test_assets: list[str] = Field(
        ["twin", "cousin_2", "cousin_6", "dissimilar", "trained"],
        min_length=1,
        description="roles to roll out on; paper: the twin, the 2nd and 6th cousin (held out), a dissimilar asset; "
        "trained: the very assets that the policy was trained on, the rollouts shared evenly: the first gate",
    )
    rollouts: int = Field(
        16, ge=1, description="episodes per test asset, the same initial states for all policies; paper: 100"
    )
    checkpoint: Literal["best", "last", "rollouts"] = Field(
        "best",
        description="best: as `training` selected; rollouts: of the checkpoints that `training: keep` left, the "
        "one with most successes on the twin (the paper's way; costs keep x selection_rollouts more episodes)",
    )
    selection_rollouts: int = Field(20, ge=1, description="episodes per checkpoint for `checkpoint: rollouts`")
    action: Literal["sample", "most_likely"] = Field(
        "most_likely", description="mode of the mixture to act by: drawn by weight (official), or the heaviest"
    )
    vary_scale: bool = Field(
        False, description="rescale the test asset at random as in the demonstrations (official: no)"
    )
    envs: int = Field(4, ge=1, description="environments that share a forward pass of the policy")
    film_frames: int = Field(16, ge=2, description="pictures of a filmed episode")

    def unread(self) -> set[str]:
        """What only the choice of a checkpoint by rollouts reads."""
        return set() if self.checkpoint == "rollouts" else {"selection_rollouts"}
