"""Training at paper size, side by side in one run: robomimic 0.3.0's BC-RNN-GMM and ours, same weights, same batch.

    bash envs/readers.sh                                # once: .venv-readers, which has robomimic
    PYTHONPATH=. .venv-readers/bin/python -m benchmarks.robomimic_training [--threads N] [--repeats N] [--warm-up N]

The weights of robomimic's network are copied into ours; losses and gradients are compared before anything is timed.
Then both take whole steps in turn (forward, backward, clipping, AdamW), so that a busy machine slows both; medians and
their ratio are printed, of process time and of wall time. `--warm-up` updates are made first (by ours): how many points
win a channel, which is what our second pass costs, changes with training. The PointNet is given to robomimic as a
modality of its own, written as a user would: embedding, two linear layers, GELU, max-pool (robomimic adds the ReLU).
"""

import argparse
import statistics
import time
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml
from robomimic.algo import algo_factory
from robomimic.config import config_factory
from robomimic.models.obs_core import EncoderCore
from robomimic.utils import obs_utils
from torch import Tensor, nn

from roomkin.stages.contracts.episode_store import ACTION, PROPRIO
from roomkin.stages.contracts.policy_config import PolicyConfig
from roomkin.stages.plugins import parse_kwargs
from roomkin.stages.policies.bc_rnn_gmm import Policy
from roomkin.stages.policies.bc_rnn_gmm_options import Options
from roomkin.stages.training.state import GRADIENT_CLIP

RUNS = yaml.safe_load(Path("config/paper/policies.yaml").read_text(encoding="utf-8"))["training"]["configs"]
PAPER = PolicyConfig.model_validate(RUNS["paper"])
KEYS = ("point_cloud", "proprio")
# our parameter -> robomimic's, both below their roots
NAMES = {
    "pointnet.flag.weight": "encoder.nets.obs.obs_nets.point_cloud.flag.weight",
    "pointnet.first": "encoder.nets.obs.obs_nets.point_cloud.first",
    "pointnet.rest.0": "encoder.nets.obs.obs_nets.point_cloud.second",
    "lstm": "rnn.nets",
    "mlp.0.0": "mlp._model.0",
    "mlp.1.0": "mlp._model.2",
}


class CloudModality(obs_utils.Modality):  # type: ignore[misc]
    """Clouds (..., P, 4) as they are."""

    name = "cloud"

    @classmethod
    def _default_obs_processor(cls, obs: Any) -> Any:
        return obs

    @classmethod
    def _default_obs_unprocessor(cls, obs: Any) -> Any:
        return obs


class DensePointNet(EncoderCore):  # type: ignore[misc]
    """The paper's PointNet, every point through every layer, forward and backward."""

    def __init__(self, input_shape: list[int], width: int = 512, flag_embedding: int = 128) -> None:
        super().__init__(input_shape)
        self.flag = nn.Embedding(2, flag_embedding)
        self.first, self.second = nn.Linear(3 + flag_embedding, width), nn.Linear(width, width)

    def output_shape(self, input_shape: list[int] | None = None) -> list[int]:
        return [self.second.out_features]

    def forward(self, inputs: Tensor) -> Tensor:
        points = torch.cat([inputs[..., :3], self.flag(inputs[..., 3].long())], dim=-1)
        pooled: Tensor = self.second(nn.functional.gelu(self.first(points))).amax(dim=1)
        return pooled


def robomimic_model(run: PolicyConfig, points: int) -> Any:
    """robomimic's BC-RNN-GMM of the sizes of a run."""
    config, options = config_factory("bc"), parse_kwargs(Options, run.kwargs)
    with config.values_unlocked():
        config.algo.optim_params.policy.optimizer_type = "adamw"
        config.algo.optim_params.policy.learning_rate.initial = run.learning_rate
        config.algo.actor_layer_dims = tuple(options.mlp)
        config.algo.gmm.enabled = config.algo.rnn.enabled = True
        config.algo.gmm.num_modes, config.algo.gmm.min_std = options.gmm_modes, options.gmm_min_std
        config.algo.rnn.horizon, config.algo.rnn.num_layers = run.horizon, 1
        config.algo.rnn.hidden_dim = options.rnn_hidden
        config.observation.modalities.obs.cloud, config.observation.modalities.obs.low_dim = [KEYS[0]], [KEYS[1]]
        config.observation.encoder.cloud.core_class = "DensePointNet"
        config.observation.encoder.cloud.core_kwargs = {"width": options.pointnet_width}
        config.observation.encoder.cloud.obs_randomizer_class = None
        config.observation.encoder.cloud.obs_randomizer_kwargs = {}
    obs_utils.initialize_obs_utils_with_config(config)
    shapes = OrderedDict([(KEYS[0], [points, 4]), (KEYS[1], [PROPRIO])])
    model = algo_factory("bc", config, obs_key_shapes=shapes, ac_dim=ACTION, device=torch.device("cpu"))
    model.set_train()
    return model


def same_parameters(ours: Policy, policy: nn.Module) -> list[tuple[nn.Parameter, list[nn.Parameter]]]:
    """Each parameter of ours, and those of robomimic's network that make it up, one below the other."""
    theirs = dict(policy.nets.named_parameters())  # type: ignore[union-attr, operator]
    pairs = []
    for name, parameter in ours.named_parameters():
        if name.startswith("head."):
            parts = [theirs[f"decoder.nets.{head}.{name[5:]}"] for head in ("logits", "mean", "scale")]
        else:
            start = next(key for key in NAMES if name.startswith(key))
            parts = [theirs[NAMES[start] + name.removeprefix(start)]]
        pairs.append((parameter, parts))
    return pairs


def join_tensors(parts: list[Tensor | None]) -> Tensor:
    """Tensors one below the other; none may be missing."""
    return torch.cat([part for part in parts if part is not None])


def batch_of(run: PolicyConfig, points: int) -> dict[str, Tensor]:
    """Clouds on the surfaces of boxes, a sixteenth of the points on the fingers; actions that follow from them."""
    random = np.random.default_rng(0)
    shape = (run.batch_size, run.horizon, points)
    center, extent = random.uniform(-0.3, 0.3, (*shape[:1], 1, 1, 3)), random.uniform(0.1, 0.6, (*shape[:1], 1, 1, 3))
    surface = random.uniform(-0.5, 0.5, (*shape, 3))
    side = random.integers(0, 3, shape)
    np.put_along_axis(surface, side[..., None], np.sign(random.uniform(-1, 1, shape))[..., None] / 2, axis=-1)
    clouds = np.concatenate([surface * extent + center, np.zeros((*shape, 1))], axis=-1)
    clouds[..., : points // 16, 3] = 1
    proprio = random.normal(0, 0.3, (*shape[:2], PROPRIO))
    actions = np.tile(np.tanh(np.concatenate([center, extent, center[..., :1]], axis=-1)[:, :, 0]), (1, shape[1], 1))
    arrays = {"point_cloud": clouds, "proprio": proprio, "actions": actions}
    return {name: torch.as_tensor(array, dtype=torch.float32) for name, array in arrays.items()}


def time_step(step: Callable[[], object]) -> tuple[float, float]:
    """Process and wall seconds of a step."""
    process, wall = time.process_time(), time.perf_counter()
    step()
    return time.process_time() - process, time.perf_counter() - wall


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--warm-up", type=int, default=10, help="updates of ours before anything is compared")
    parser.add_argument("--precision", choices=["fp32", "bf16"], default="fp32", help="of our PointNet")
    parser.add_argument("--points", type=int, default=PAPER.points)
    parser.add_argument("--batch", type=int, default=PAPER.batch_size)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    torch.manual_seed(0)
    kwargs = PAPER.kwargs | {"precision": arguments.precision}
    run = PAPER.model_copy(update={"batch_size": arguments.batch, "kwargs": kwargs})
    data = batch_of(run, arguments.points)
    robomimic, ours = robomimic_model(run, arguments.points), Policy(run)
    policy = robomimic.nets["policy"]
    pairs = same_parameters(ours, policy)
    for parameter, parts in pairs:
        parameter.data.copy_(join_tensors([part.data for part in parts]))
    optimiser = torch.optim.AdamW(ours.parameters(), lr=run.learning_rate, weight_decay=0.0, fused=True)
    batch = {"obs": {key: data[key] for key in KEYS}, "actions": data["actions"], "goal_obs": None}
    ones = torch.ones(data["actions"].shape[:2])

    def our_loss() -> Tensor:
        return ours.loss(data["point_cloud"], data["proprio"], data["actions"], ones)[0]

    def our_step() -> None:
        optimiser.zero_grad()
        our_loss().backward()
        torch.nn.utils.clip_grad_norm_(ours.parameters(), GRADIENT_CLIP)
        optimiser.step()

    def their_step() -> None:
        robomimic.log_info(robomimic.train_on_batch(robomimic.process_batch_for_training(batch), epoch=1))

    for _ in range(arguments.warm_up):
        our_step()
    for parameter, parts in pairs:  # back again
        for part, values in zip(parts, parameter.data.split([len(part) for part in parts]), strict=True):
            part.data.copy_(values)
    with torch.no_grad():
        winner = ours.pointnet._winners(data["point_cloud"].flatten(0, 1))[1]
    winners = statistics.mean(len(row.unique()) for row in winner)

    optimiser.zero_grad()
    loss = our_loss()
    loss.backward()
    policy.zero_grad()
    their_loss = -policy.forward_train(batch["obs"]).log_prob(batch["actions"]).mean()
    their_loss.backward()
    gradients = [(ours_.grad, join_tensors([part.grad for part in parts])) for ours_, parts in pairs]
    square = sum(float((a - b).square().sum()) for a, b in gradients if a is not None)
    norm = sum(float(b.square().sum()) for _, b in gradients)
    print(f"loss: robomimic {their_loss.item():.6f}, ours {loss.item():.6f}")
    print(f"gradient: relative difference {(square / norm) ** 0.5:.1e}; {winners:.0f} of {arguments.points} points win")

    theirs, mine = [], []
    for number in range(arguments.repeats):
        theirs.append(time_step(their_step))
        mine.append(time_step(our_step))
        print(f"step {number}: robomimic {theirs[-1][1]:.2f} s, ours {mine[-1][1]:.2f} s", flush=True)
    for kind, column in (("process", 0), ("wall", 1)):
        a, b = (statistics.median(row[column] for row in rows) for rows in (theirs, mine))
        print(f"{kind} time per step: robomimic {a:.2f} s, ours {b:.2f} s, ratio {a / b:.1f}")


if __name__ == "__main__":
    main()
