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

from stages.geometry.planes import fit_plane
from stages.policies.bc_rnn_gmm.network import BcRnnGmm
from stages.policies.checkpoint import load_policy
from stages.training.dataset import read_demonstrations

STEPS = 5  # of an episode that are looked at, all of them on the way to the handle
SHIFT = 0.08  # metres
BEFORE, PLANE = 0.012, 0.006  # metres: a point stands before the front, or lies in its plane
HYPOTHESES = 200  # of the front's plane


def answers(policy: BcRnnGmm, clouds: Tensor, proprio: Tensor, full_step: float) -> dict[str, float] | None:
    """Sideways motion (cm per step) for what is shown of one episode's first clouds (T, P, 4); None: no handle seen.

    An action of 1 moves the hand by `full_step` metres. The robot stands on the side of -x.
    """
    finger = clouds[0, :, 3] > 0.5
    plane = fit_plane(clouds[0, ~finger, :3].numpy(), PLANE, HYPOTHESES, np.random.default_rng(0))
    assert plane is not None, "three points make a plane"
    towards = -float(np.sign(plane.normal[0]))
    normal = torch.from_numpy(towards * plane.normal).float()
    handle = (clouds[0, :, :3] @ normal - towards * plane.offset > BEFORE) & ~finger
    if handle.sum() < 3:
        return None
    sideways = torch.stack([-normal[1], normal[0], torch.tensor(0.0)])
    sideways = sideways / sideways.norm()

    def answer(shown: Tensor) -> float:
        with torch.no_grad():
            mixture = policy(shown[None], proprio[None])
        mean = (mixture.logits.softmax(-1)[..., None] * mixture.means).sum(-2)[0]
        return float((mean[:, :3] @ sideways).mean()) * 100 * full_step

    def moved(which: Tensor) -> float:
        shown = clouds.clone()
        shown[:, which, :3] += SHIFT * sideways
        return answer(shown) - plain

    plain = answer(clouds)
    rest = (~handle).nonzero().squeeze(1)
    without = clouds[:, rest[torch.arange(len(handle)) % len(rest)]]
    return {
        "no handle": abs(answer(without) - plain),
        "handle moved": moved(handle),
        "front moved": moved(~handle & ~finger),
        "both moved": moved(~finger),
        "handle points": int(handle.sum()),
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
        policy = load_policy(folder, "last", "cpu")
        assert isinstance(policy, BcRnnGmm), f"{folder}: only bc_rnn_gmm is looked into"
        found = []
        for start, length in zip(starts, data.lengths, strict=True):
            first = slice(start, start + min(STEPS, length))
            step = data.task_options.position_step
            found.append(answers(policy, data.clouds[first].float(), data.proprio[first], step))
        table = pd.DataFrame([row for row in found if row is not None])
        rows.append({"policy": "/".join(folder.parts[-3:]), "episodes": len(table), **table.mean().round(3).to_dict()})
    print(pd.DataFrame(rows).to_string(index=False))


if __name__ == "__main__":
    main()
