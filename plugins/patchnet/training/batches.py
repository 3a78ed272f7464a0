"""Batches of the rendered pairs: several models, several views of each, in other colours at every look."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from plugins.patchnet.network import GRID, SIZE, normalise_crops
from plugins.patchnet.training.options import TrainingOptions
from stages.contracts.errors import InputError

LIGHTNESS = 127.5  # the grey outside the mask


@dataclass(frozen=True)
class Batch:
    """`crops` (2, B, 4, SIZE, SIZE): pictures and snapshots; `matches` (B, P), `visible` (2, B, P), and (B,) `models`,
    `yaws`, `periods`."""

    crops: Tensor
    matches: Tensor
    visible: Tensor
    models: Tensor
    yaws: Tensor
    periods: Tensor


class Pairs:
    """What `render` wrote, opened for reading."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise InputError(path, "no such file.", "python -m plugins.patchnet makes it", code="E-FILE-MISSING")
        self._file = h5py.File(path, "r")
        self.about = str(self._file.attrs["about"])  # options and seed of `render`
        self.models = len(self._file["models"])
        self.categories = sorted({name.decode().rpartition("_")[0] for name in self._file["models"]})
        self.views = len(self._file["crops"]) // self.models

    def gather(self, model: int, views: NDArray[np.intp]) -> dict[str, NDArray[np.generic]]:
        """Some views of one model; `views` ascending."""
        file, at = self._file, model * self.views + views
        period = np.full(len(views), file["periods"][model])
        return {"crops": file["crops"][at], "matches": file["matches"][at], "yaws": file["yaws"][at], "periods": period}


def draw(pairs: Pairs, step: int, seed: int, options: TrainingOptions) -> Batch:
    """The batch of an update: it depends on seed and step alone, so that a run can be resumed."""
    rng = np.random.default_rng(np.random.SeedSequence((seed, step)))
    models = rng.choice(pairs.models, min(options.batch_models, pairs.models), replace=False)
    chosen = [np.sort(rng.choice(pairs.views, min(options.batch_views, pairs.views), replace=False)) for _ in models]
    parts = [pairs.gather(int(model), views) for model, views in zip(models, chosen, strict=True)]
    both = {key: torch.from_numpy(np.concatenate([part[key] for part in parts])) for key in parts[0]}
    of_model = torch.from_numpy(np.repeat(np.arange(len(models)), len(chosen[0])))
    crops = both["crops"].permute(1, 0, 4, 2, 3).float()
    matches = both["matches"].long()
    mirrored = torch.from_numpy(rng.random(len(models)) < 0.5)[of_model]  # a model whole: its views stay consistent
    crops[:, mirrored] = crops[:, mirrored].flip(-1)
    matches[mirrored] = mirror(matches[mirrored])
    share = functional.adaptive_avg_pool2d(crops[:, :, 3], GRID).flatten(2)
    crops = torch.stack([recolour_crops(side, rng) for side in crops])
    return Batch(crops, matches, share >= LIGHTNESS, of_model, both["yaws"], both["periods"])


def mirror(matches: Tensor) -> Tensor:
    """Matches (B, P) of pairs both of whose pictures are mirrored."""
    count = GRID * GRID
    flipped = torch.arange(count).view(GRID, GRID).flip(1).flatten()
    seen = matches >= 0
    return torch.where(seen, flipped[matches.clamp(min=0)], matches)[:, flipped]


def recolour_crops(crops: Tensor, rng: np.random.Generator) -> Tensor:
    """Crops (B, 4, H, W) as the network takes them: channels mixed, some inverted, some textured, grey outside."""
    count = len(crops)
    mix = np.eye(3) * rng.uniform(0.4, 1.0, (count, 1, 1)) + rng.uniform(-0.4, 0.4, (count, 3, 3))
    mix *= rng.uniform(0.6, 1.2, (count, 1, 1)) * np.where(rng.random(count) < 0.1, -1.0, 1.0)[:, None, None]
    shift = rng.uniform(-40, 40, (count, 3))
    colours = crops[:, :3] - LIGHTNESS
    colours = torch.einsum("bij,bjhw->bihw", torch.from_numpy(mix).float(), colours)
    colours += torch.from_numpy(shift).float()[:, :, None, None]
    for number in np.flatnonzero(rng.random(count) < 0.4):
        colours[number] += texture(rng)
    coverage = crops[:, 3:]
    colours = colours.clamp(-LIGHTNESS, LIGHTNESS) * (coverage / 255)
    return normalise_crops(torch.cat([colours + LIGHTNESS, coverage], dim=1))


def texture(rng: np.random.Generator) -> Tensor:
    """A pattern (1, SIZE, SIZE) of spots, stripes or tiles, up to a sixth as strong as black and white."""
    rows, columns = 2 ** rng.uniform(1, 6, 2)
    noise = torch.from_numpy(rng.normal(size=(1, 1, int(rows), int(columns)))).float()
    if rng.random() < 0.3:
        noise = noise.sign()
    mode = "nearest" if rng.random() < 0.3 else "bilinear"
    return functional.interpolate(noise, size=(SIZE, SIZE), mode=mode)[0] * float(rng.uniform(4, 20))
