"""Everything an interrupted run needs to go on: weights, optimiser, best weights, the lines logged so far."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from roomkin.stages.contracts.errors import explain
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.policies.base import TrainablePolicy
from roomkin.stages.training.logbook import Line

STATE = "state.pt"
KEPT = ("step", "best_step", "best_loss", "best", "lines")


@dataclass
class TrainingState:
    """The run after `step` updates. `fingerprint` names data, options and seed: another run must not go on from it."""

    optimiser: torch.optim.Optimizer
    fingerprint: str
    step: int = 0
    saved: int = 0
    best_step: int = 0
    best_loss: float | None = None
    best: dict[str, Tensor] = field(default_factory=dict)
    lines: list[Line] = field(default_factory=list)

    def note(self, policy: TrainablePolicy, validation_loss: float | None, line: Line, select: str) -> None:
        """Remember the line, and the weights if they are the best so far (without validation: the last ones)."""
        self.lines.append(line)
        latest = select == "last" or validation_loss is None
        if latest or self.best_loss is None or (validation_loss is not None and validation_loss < self.best_loss):
            self.best_step, self.best_loss = self.step, validation_loss
            self.best = copy_weights(policy.state_dict())

    def is_due(self, every: int) -> bool:
        """Whether `every` steps have passed since the last save."""
        return self.step - self.saved >= every

    def save(self, policy: TrainablePolicy, folder: Path) -> None:
        """Write the state; a crash while writing leaves the last one."""
        self.saved = self.step
        content = {
            "policy": policy.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "fingerprint": self.fingerprint,
            **{name: getattr(self, name) for name in KEPT},
        }
        with write_atomically(folder / STATE) as temporary:
            torch.save(content, temporary)

    def resume(self, policy: TrainablePolicy, folder: Path) -> bool:
        """Go on from the state in `folder` if there is one of this very run; any other is set aside."""
        path = folder / STATE
        if not path.is_file():
            return False
        try:
            content = torch.load(path, weights_only=True, map_location="cpu")
            reason = self._fault(content, policy)
        except Exception as error:  # torch, zipfile and pickle raise many kinds for a broken file
            reason = f"cannot be read ({explain(error)})"
        if reason:
            refused = path.replace(path.with_name(f"{STATE}.refused"))
            print(f"training: {path} {reason}; kept as {refused.name}, training starts over", file=sys.stderr)
            return False
        policy.load_state_dict(content["policy"])
        self.optimiser.load_state_dict(content["optimiser"])
        for name in KEPT:
            setattr(self, name, content[name])
        self.saved = self.step
        return True

    def _fault(self, content: Any, policy: TrainablePolicy) -> str:
        """Why the content of a state file is of no use; '' if nothing is wrong with it."""
        if not isinstance(content, dict) or not set(content) >= {"policy", "optimiser", "fingerprint", *KEPT}:
            return "is no training state"
        if content["fingerprint"] != self.fingerprint:
            return "is of a run with other data, options, seed or code"
        weights = policy.state_dict()
        for name in ("policy", "best"):
            shapes = {key: tensor.shape for key, tensor in content[name].items()}
            if shapes != {key: tensor.shape for key, tensor in weights.items()} and (name == "policy" or shapes):
                return f"holds other weights ({name})"
        groups = [group["params"] for group in content["optimiser"]["param_groups"]]
        if [len(group) for group in groups] != [len(group["params"]) for group in self.optimiser.param_groups]:
            return "holds another optimiser"
        return ""


def copy_weights(weights: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """A copy that later updates do not touch."""
    return {name: tensor.detach().clone() for name, tensor in weights.items()}
