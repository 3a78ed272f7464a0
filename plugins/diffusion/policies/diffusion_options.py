"""Options of the policy `diffusion`."""

from typing import Self

from pydantic import Field, model_validator

from roomkin.stages.policies.bc_rnn_gmm_options import PointCloudOptions


class Options(PointCloudOptions):
    """How actions are denoised."""

    num_train_timesteps: int = Field(100, ge=2, description="noise levels in training")
    num_inference_steps: int = Field(
        10, ge=1, description="of them, evenly spaced, those that are denoised in closed loop (DDIM)"
    )
    n_action_steps: int = Field(4, ge=1, description="of the `horizon` actions, those done between two observations")
    width: int = Field(256, ge=8, description="of the layers that denoise")
    layers: int = Field(3, ge=1, description="how many they are")

    @model_validator(mode="after")
    def _fewer_steps(self) -> Self:
        if self.num_inference_steps > self.num_train_timesteps:
            raise ValueError(
                f"num_inference_steps is {self.num_inference_steps}, more than num_train_timesteps, "
                f"{self.num_train_timesteps}"
            )
        return self
