"""How well the network of plugins/names names shapes alone: in random rooms of models that did not teach it.

python -m benchmarks.shapes [--rooms 120] [--network FILE]
"""

import argparse
from pathlib import Path

import numpy as np
import torch

from benchmarks.names import report_certainty
from plugins.names.propose import NETWORK, read_network
from plugins.names.training.draw import draw_examples, list_names

SEED, MODELS = 999, 8  # of the rooms, none of which `learn` draws, and models of a kind
AT_ONCE = 512


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rooms", type=int, default=120)
    parser.add_argument("--network", type=Path, default=NETWORK)
    asked = parser.parse_args()
    network, names = read_network(asked.network)
    drawn = draw_examples(asked.rooms, MODELS, SEED)
    parts = [torch.from_numpy(part).float().split(AT_ONCE) for part in drawn[:3]]
    with torch.inference_mode():
        share = torch.cat([network(*some) for some in zip(*parts, strict=True)]).double().softmax(dim=1).numpy()
    right = np.array([[name == list_names()[one] for name in names] for one in drawn.name])
    things = ~right[:, -1]
    order = np.argsort(-share[things, :-1], axis=1, kind="stable")
    hits = np.take_along_axis(right[things], order, axis=1)
    print(
        f"{things.sum()} things: first right {hits[:, 0].mean():.2f}, one of three {hits[:, :3].any(axis=1).mean():.2f}"
    )
    report_certainty(share, right)


if __name__ == "__main__":
    main()
