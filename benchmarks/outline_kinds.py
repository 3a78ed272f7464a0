"""Learn what outlines of a picture show (outline_kinds.safetensors) from open rooms, and judge it.

python -m benchmarks.open_rooms render DIR --half work --learning 9
python -m benchmarks.outline_kinds DIR --judge held_out --write

It learns from DIR/learning; judged are the pictures of a half in DIR/pictures.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import save_file

from benchmarks.open_rooms.pictures import folders, read, read_masks
from roomkin.stages.cli import progress
from roomkin.stages.config.perception import SeeSection
from roomkin.stages.contracts import write_atomically
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.perception.layout import things
from roomkin.stages.perception.segmentation.choosing import choose
from roomkin.stages.perception.segmentation.proposal import list_proposals

Array = NDArray[np.float64]
OF_ROOM, SAME = 0.7, 0.5  # share of an outline that is wall or floor; IoU from which on it shows a thing
RIDGE = 0.1  # chosen on real outlines and `held_out`: .03 to .3 are alike


def see_examples(folder: Path) -> tuple[Array, list[int]]:
    """What is known of the outlines of a picture (N, 779), and what each shows, by its place in `KINDS`."""
    rgb, truth, owner = read_rgb(folder / "rgb.png"), read(folder), read_masks(folder)
    view, support = things.make_view(rgb), {thing.number: thing.support for thing in truth.things}
    values = {int(value): label for value, label in json.loads((folder / "exact.json").read_text()).items()}
    kinds = {"floor": things.STANDS, "wall": things.HANGS}
    shown, examples = list[int](), list[Array]()
    for one in choose(view, list_proposals(view, SeeSection(), SeeSection().proposers)):
        inside = np.bincount(owner[one.mask], minlength=int(owner.max()) + 1)
        floor = sum(inside[value] for value, label in values.items() if label == "floor")
        wall = inside[0] + sum(inside[value] for value, label in values.items() if label == "wall")
        ious = {value: inside[value] / (one.mask | (owner == value)).sum() for value in support}
        best = max(ious, key=lambda value: ious[value], default=0)
        kind = things.NOTHING
        if max(wall, floor) > OF_ROOM * one.mask.sum():
            kind = things.WALL if wall > floor else things.FLOOR
        elif best and ious[best] > SAME:
            kind = kinds.get(support[best], things.RESTS)
        shown.append(things.KINDS.index(kind))
        examples.append(things.measure_outline(view.embedded.features, one.mask))
    return np.array(examples), shown


def learn(examples: Array, shown: Sequence[int]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Weights (779, 6) and bias (6,) of a logistic regression with a ridge, for columns as they are."""
    mean, spread = examples.mean(axis=0), examples.std(axis=0) + 1e-6
    inputs, target = torch.from_numpy((examples - mean) / spread), torch.tensor(shown)
    weights = torch.zeros(examples.shape[1], len(things.KINDS), dtype=torch.float64, requires_grad=True)
    bias = torch.zeros(len(things.KINDS), dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.LBFGS([weights, bias], max_iter=300, line_search_fn="strong_wolfe")

    def step() -> torch.Tensor:
        optimizer.zero_grad()
        loss = torch.nn.functional.cross_entropy(inputs @ weights + bias, target) + RIDGE * (weights**2).sum()
        loss.backward()  # type: ignore[no-untyped-call]
        return loss

    optimizer.step(step)  # type: ignore[no-untyped-call]
    scaled = weights.detach().numpy() / spread[:, None]
    return scaled.astype(np.float32), (bias.detach().numpy() - mean @ scaled).astype(np.float32)


def see_all(found: Sequence[Path]) -> tuple[Array, list[int]]:
    """The examples of pictures."""
    seen = [see_examples(folder) for folder in progress(found, "pictures")]
    return np.concatenate([one for one, _ in seen]), [kind for _, kinds in seen for kind in kinds]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--judge", default="work", help="half of the pictures that are judged")
    parser.add_argument("--write", action="store_true", help="write the weights")
    asked = parser.parse_args()
    weights, bias = learn(*see_all(folders(asked.folder, kept="learning")))
    examples, shown = see_all(folders(asked.folder, asked.judge))
    told = (examples @ weights + bias).argmax(axis=1)
    table = np.zeros((len(things.KINDS), len(things.KINDS)), int)
    np.add.at(table, (shown, told), 1)
    print(f"{asked.judge}: {(told == shown).sum()} of {len(shown)} right; a row per true kind, columns as told")
    for kind, row in zip(things.KINDS, table, strict=True):
        print(f"{kind:8}", *(f"{count:4}" for count in row))
    if asked.write:
        with write_atomically(things.WEIGHTS) as path:
            save_file({"weights": weights, "bias": bias}, path)


if __name__ == "__main__":
    main()
