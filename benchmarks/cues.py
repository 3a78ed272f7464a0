"""What of a door or drawer a policy goes by: its front or its handle. One table, seconds per policy:

    python -m benchmarks.cues --policies results/training/drawer/cousins_8/lite/seed_* \\
        --episodes results/demonstrations/drawer/cousin_1/episodes.h5

For the first steps of every episode the policy is shown the demonstration's clouds as they are, without the points of
the handle, and with handle, front or both moved sideways. Printed is the mean sideways motion that it answers with, in
centimetres per step: what it goes by moves it, what it does not see leaves it as it is.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from plugins.handle.handle_points import mark_handle_points
from stages.policies.bc_rnn_gmm.network import BcRnnGmm
from stages.policies.checkpoint import load_network
from stages.training.dataset import read_demonstrations

STEPS = 5  # of an episode that are looked at, all of them on the way to the handle
SHIFT = 0.08  # metres
LEAST = 3  # points of a handle in every cloud


def measure_answers(policy: BcRnnGmm, clouds: Tensor, proprio: Tensor, full_step: float) -> dict[str, float] | None:
    """Sideways motion (cm per step) for what is shown of one episode's first clouds (T, P, 4); None: no handle seen.

    What protrudes from the front is the handle, found in every cloud anew: points have another order in each. An
    action of 1 moves the hand by `full_step` metres.
    """
    marked, planes = mark_handle_points(clouds)
    handle, front = marked[..., 3] == -1, marked[..., 3] == 0
    if handle.sum(1).min() < LEAST:
        return None
    sideways = torch.stack([-planes[0, 1], planes[0, 0], torch.tensor(0.0)])

    def answer(shown: Tensor) -> float:
        if not policy.run.handle:
            shown = torch.cat([shown[..., :3], shown[..., 3:].clamp_min(0)], dim=-1)
        with torch.no_grad():
            mixture = policy(shown[None], proprio[None])
        mean = (mixture.logits.softmax(-1)[..., None] * mixture.means).sum(-2)[0]
        return float((mean[:, :3] @ sideways).mean()) * 100 * full_step

    def measure_motion(which: Tensor) -> float:
        shown = marked.clone()
        shown[which] += torch.cat([SHIFT * sideways, torch.zeros(1)])
        return answer(shown) - plain

    plain = answer(marked)
    without = marked.clone()
    for frame, its, others in zip(without, handle, front, strict=True):
        rest = frame[others]
        frame[its] = rest[torch.arange(int(its.sum())) % len(rest)]
    return {
        "no handle": abs(answer(without) - plain),
        "handle moved": measure_motion(handle),
        "front moved": measure_motion(front),
        "both moved": measure_motion(handle | front),
        "handle points": float(handle.sum(1).float().mean()),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", type=Path, nargs="+", required=True, help="folders of trained policies")
    parser.add_argument("--episodes", type=Path, required=True, help="episodes.h5 of one asset")
    parser.add_argument("--count", type=int, default=24, help="episodes looked at")
    given = parser.parse_args()
    data = read_demonstrations([given.episodes], given.count)
    starts = np.cumsum([0, *data.lengths[:-1]])
    rows = []
    for folder in given.policies:
        policy = load_network(folder, "last", "cpu")
        assert isinstance(policy, BcRnnGmm), f"{folder}: only bc_rnn_gmm is looked into"
        found = []
        for start, length in zip(starts, data.lengths, strict=True):
            first = slice(start, start + min(STEPS, length))
            step = data.task_options.position_step
            found.append(measure_answers(policy, data.clouds[first].float(), data.proprio[first], step))
        table = pd.DataFrame([row for row in found if row is not None])
        rows.append({"policy": "/".join(folder.parts[-3:]), "episodes": len(table), **table.mean().round(3).to_dict()})
    print(pd.DataFrame(rows).to_string(index=False))


if __name__ == "__main__":
    main()
