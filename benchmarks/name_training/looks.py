"""Command `looks`: learn names of CLIP's embeddings from pictures of many models, and the weights of all voices."""

import json
from pathlib import Path

import h5py
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from tqdm import tqdm

from benchmarks.name_training.learn import write_network
from benchmarks.name_training.outlines import TrainingOutlines, join, see_outlines
from benchmarks.open_rooms.pictures import folders
from roomkin.stages.contracts import write_atomically
from roomkin.stages.perception.classification.clip import embed, load_tower, show
from roomkin.stages.perception.classification.propose import HEAD, read_network

SCALE = 10.0  # of embeddings, so that weights are near 1
DECAY = 1e-3  # of squared weights; chosen by `benchmarks.names`
VIEWS = 2  # snapshots of a model of the library; chosen
FOLDS = 5  # parts of the models, each named by a head that has not seen it
Array = NDArray[np.float64]


def train_head(looks: NDArray[np.float32], right: NDArray[np.bool_]) -> nn.Linear:
    """The layer from embeddings (N, 512) to names (C,), any of those that are right for each (N, C) alike.

    Its probabilities are of names that are all as likely before (logit adjustment, Menon et al. 2021).
    """
    torch.manual_seed(0)
    inputs, told = torch.from_numpy(SCALE * looks).double(), torch.from_numpy(right).double()
    common = ((told / told.sum(dim=1, keepdim=True)).sum(dim=0) + 1).log()
    layer = nn.Linear(looks.shape[1], right.shape[1]).double()
    nn.init.zeros_(layer.weight)
    nn.init.zeros_(layer.bias)
    optimiser = torch.optim.LBFGS(layer.parameters(), max_iter=300, line_search_fn="strong_wolfe")

    def step() -> Tensor:
        optimiser.zero_grad()
        shares = (layer(inputs) + common).log_softmax(dim=1)
        loss = -torch.logsumexp(shares + told.log(), dim=1).mean() + DECAY * layer.weight.square().sum()
        loss.backward()
        return loss

    optimiser.step(step)  # type: ignore[no-untyped-call]
    with torch.no_grad():
        layer.weight *= SCALE
    return layer.float().eval()


def share_out_of_fold(seen: TrainingOutlines, right: NDArray[np.bool_]) -> Array:
    """Probabilities (N, C) by heads that have seen no outline of the same model."""
    rng, share = np.random.default_rng(0), np.zeros(right.shape)
    models = sorted(set(seen.model) - {""})
    part = {model: k % FOLDS for k, model in enumerate(rng.permutation(models))}
    fold = np.array([part.get(model, int(rng.integers(FOLDS))) for model in seen.model])
    for k in range(FOLDS):
        head = train_head(seen.looks[fold != k], right[fold != k])
        with torch.inference_mode():
            share[fold == k] = head(torch.from_numpy(seen.looks[fold == k])).double().softmax(dim=1).numpy()
    return share


def see_library(snapshots: Path, kept: Path) -> tuple[NDArray[np.float32], list[str]]:
    """Embeddings (N, 512) of the library's models, of two snapshots each, and their categories; kept in a file."""
    if not kept.is_file():
        looks, names, rng, tower = [], list[str](), np.random.default_rng(0), load_tower()
        assert tower is not None, "CLIP's weights are not here"
        for path in sorted(snapshots.glob("shard_*.h5")):
            assets = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))["assets"]
            with h5py.File(path) as file:
                for number, asset in enumerate(assets):
                    for view in rng.permutation(len(file["rgb"][number]))[:VIEWS]:
                        rgb, mask = file["rgb"][number, view], file["depth"][number, view] > 0
                        looks.append(show(np.where(mask[..., None], rgb, rng.integers(60, 200, 3, np.uint8)), mask))
                        names.append(asset.rsplit("_", 1)[0])
        with write_atomically(kept) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(stream, looks=embed(tower, np.array(looks)), names=names)
    with np.load(kept) as stored:
        return stored["looks"], stored["names"].tolist()


def run(*, pictures: Path, library: Path, out: Path = HEAD) -> None:
    """Write the layer.

    Args:
        pictures: folder of `python -m benchmarks.open_rooms render --half work --learning 6`.
        library: results folder with snapshots of the default library.
        out: the file.
    """
    torch.set_num_threads(1)
    _, names = read_network()
    seen = read_learning(pictures)
    looks, called = see_library(library / "assets/snapshots", pictures / "seen/library.npz")
    right = np.concatenate([seen.right(names), [[name == one for name in names] for one in called]])
    write_network(out, train_head(np.concatenate([seen.looks, looks]), right), names)
    print(f"{out}: {out.stat().st_size / 1e3:.0f} kB, of {len(right)} outlines")


def read_learning(pictures: Path) -> TrainingOutlines:
    """All outlines of the pictures that are there to learn from, and of those of the half `work`."""
    every = [*folders(pictures, "work", "learning"), *folders(pictures, "work")]
    found = (see_outlines(one, pictures / "seen") for one in tqdm(every, unit="picture"))
    return join([one for one in found if one is not None])
