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

from stages.policies.bc_rnn_gmm.network import BcRnnGmm
from stages.policies.checkpoint import load_policy
from stages.training.dataset import read_demonstrations

STEPS = 5  # of an episode that are looked at, all of them on the way to the handle
SHIFT = 0.08  # metres
BEFORE, PLANE = 0.012, 0.006  # metres: a point stands before the front, or lies in its plane
FULL_STEP = 5.0  # centimetres that an action of 1 moves the hand


def front(points: Tensor, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Normal towards the robot (-x) and a point of the plane with most of the points (N, 3), by RANSAC."""
    best, found = -1, (points[0], points[0])
    for _ in range(200):
        a, b, c = points[torch.randint(len(points), (3,), generator=random)]
        normal = torch.linalg.cross(b - a, c - a)
        if normal.norm() < 1e-6:
            continue
        normal = normal / normal.norm() * (-1 if normal[0] > 0 else 1)
        count = int((((points - a) @ normal).abs() < PLANE).sum())
        if count > best:
            best, found = count, (normal, a)
    return found


def answers(policy: BcRnnGmm, clouds: Tensor, proprio: Tensor, random: torch.Generator) -> dict[str, float] | None:
    """Sideways motion (cm per step) for what is shown of one episode's first clouds (T, P, 4); None: no handle seen."""
    finger = clouds[0, :, 3] > 0.5
    normal, origin = front(clouds[0, ~finger, :3], random)
    handle = ((clouds[0, :, :3] - origin) @ normal > BEFORE) & ~finger
    if handle.sum() < 3:
        return None
    sideways = torch.stack([-normal[1], normal[0], torch.tensor(0.0)])
    sideways = sideways / sideways.norm()

    def answer(shown: Tensor) -> float:
        with torch.no_grad():
            mixture = policy(shown[None], proprio[None])
        mean = (mixture.logits.softmax(-1)[..., None] * mixture.means).sum(-2)[0]
        return float((mean[:, :3] @ sideways).mean()) * FULL_STEP

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
        random = torch.Generator().manual_seed(0)
        seen = [
            slice(start, start + min(2 * STEPS, length)) for start, length in zip(starts, data.lengths, strict=True)
        ]
        found = [answers(policy, data.clouds[some].float(), data.proprio[some], random) for some in seen]
        table = pd.DataFrame([row for row in found if row is not None])
        rows.append({"policy": "/".join(folder.parts[-3:]), "episodes": len(table), **table.mean().round(3).to_dict()})
    print(pd.DataFrame(rows).to_string(index=False))


if __name__ == "__main__":
    main()
