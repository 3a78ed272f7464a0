"""Policies: what `training` trains and `evaluation` rolls out; one folder each, and their files. No simulator (B.3)."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Literal, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from stages.contracts.training_run import TrainingRun
from stages.plugins import load
from stages.policies.marking import load_marker

Float = NDArray[np.float32]
Choice = Literal["sample", "sharpened", "most_likely"]


class ActorProtocol(Protocol):
    """A policy in closed loop on several environments, each in a slot with its own memory."""

    def reset(self, slot: int, seed: int) -> None:
        """Start an episode; `seed` decides every random choice of it."""
        ...

    def act(self, slots: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """Actions (n, 7) in [-1, 1] of the environments in `slots`, from clouds (P, 4) and proprioception (9,)."""
        ...


class TrainablePolicy(nn.Module, ABC):
    """What an implementation's `Policy` is: made from a hyper-parameter set, with its normaliser as buffers.

    Clouds (..., P, 4) are x, y, z and a flag: 1 finger, 0 scene and, with `run.handle`, -1 the handle,
    marked before a policy sees the clouds, in training and in closed loop. Proprioception (..., 9) is
    end-effector position, quaternion wxyz and fingers, actions (..., 7) are in [-1, 1]; metres, robot base frame.
    """

    def __init__(self, run: TrainingRun) -> None:
        super().__init__()
        self.run = run

    def fit(self, clouds: Tensor, proprio: Tensor, actions: Tensor, frames: Tensor) -> None:
        """Fit normaliser and start before training; `frames` are the rows of the three that are to be trained on.

        What is kept goes into buffers that `__init__` registered at their size. A policy without parameters is fitted
        alone: `steps: 1`.
        """

    @abstractmethod
    def loss(self, clouds: Tensor, proprio: Tensor, actions: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Loss of sequences (B, T, ...), and the RMS error of the actions; steps with weight 0 do not count.

        `self.training` is false when validation episodes are looked at.
        """

    @abstractmethod
    def actor(self, slots: int, choose: Choice) -> ActorProtocol:
        """The policy in closed loop, with as many memories as there are environments."""


def make_policy(run: TrainingRun) -> TrainablePolicy:
    """The policy that a hyper-parameter set names, not yet trained."""
    policy: TrainablePolicy = load("policies", run.policy)(run)
    return policy


class MarkingActor:
    """An actor whose clouds are marked before it sees them."""

    def __init__(self, actor: ActorProtocol) -> None:
        self.actor, self.mark = actor, load_marker().mark

    def reset(self, slot: int, seed: int) -> None:
        """Start an episode."""
        self.actor.reset(slot, seed)

    def act(self, slots: Sequence[int], clouds: Sequence[Float], proprio: Sequence[Float]) -> Float:
        """The actor's actions for the marked clouds."""
        return self.actor.act(slots, list(self.mark(torch.from_numpy(np.stack(clouds)))[0].numpy()), proprio)


def make_actor(policy: TrainablePolicy, slots: int, choose: Choice) -> ActorProtocol:
    """The policy acting on as many environments; its clouds are what they were in training."""
    actor = policy.actor(slots, choose)
    return MarkingActor(actor) if policy.run.handle else actor
