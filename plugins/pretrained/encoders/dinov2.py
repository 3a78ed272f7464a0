"""Patch encoder `dinov2` (paper A.6): the last layer's normalised patch tokens of DINOv2 (Oquab et al. 2023).

Weights are those of a folder as on the hub, or of the published file that `fetch` brings.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.config.weights import DINOV2, check_folder, find_weights, weights_sha256
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.errors import explain
from roomkin.stages.geometry.masks import ObjectView, cut, foreground, masked_square, patch_positions
from roomkin.stages.matching.encoders import Patches
from roomkin.stages.perception.classification.clip import Layer, read_published

HEAD, EPSILON = 64, 1e-6  # numbers a head of attention; of the normalisations; in every size of it
PLACES = "embeddings.position_embeddings"
# In the published file: places of the whole and of 37 x 37 patches.
NAMELESS = ("onnx::Concat_1957", "onnx::Reshape_1962")
MEAN, STD = np.array([0.485, 0.456, 0.406], np.float32), np.array([0.229, 0.224, 0.225], np.float32)  # ImageNet's


class Dinov2(nn.Module):
    """Pictures (B, 3, h * patch, w * patch), normalised as ImageNet's -> last tokens of their patches (B, h * w, D)."""

    def __init__(self, width: int, layers: int, patch: int, side: int) -> None:
        super().__init__()
        self.patch, self.side = patch, side
        self.patches = nn.Conv2d(3, width, patch, patch)
        self.whole = nn.Parameter(torch.zeros(width))
        self.places = nn.Parameter(torch.zeros(side**2 + 1, width))
        self.layers = nn.Sequential(*(Layer(width, width // HEAD, nn.GELU(), EPSILON) for _ in range(layers)))
        self.last = nn.LayerNorm(width, EPSILON)

    def forward(self, x: Tensor) -> Tensor:
        """See the class; the places, learnt on a square of `side` patches, are stretched to those of the picture."""
        patches = self.patches(x)
        grid = self.places[1:].T.unflatten(1, (self.side, self.side))[None]
        grid = nn.functional.interpolate(grid, patches.shape[2:], mode="bicubic")
        tokens = (patches + grid).flatten(2).transpose(1, 2)
        whole = (self.whole + self.places[0]).expand(len(x), 1, -1)
        found: Tensor = self.last(self.layers(torch.cat([whole, tokens], dim=1)))[:, 1:]
        return found


def fill(published: dict[str, Tensor]) -> Dinov2:
    """The network with weights by their published names; the scale of each layer's results is multiplied into them."""
    kernel, places = published["embeddings.patch_embeddings.projection.weight"], published[PLACES][0]
    layers = sum(name.endswith("norm1.weight") for name in published)
    network = Dinov2(places.shape[1], layers, kernel.shape[-1], round((len(places) - 1) ** 0.5))
    named = {"whole": published["embeddings.cls_token"].flatten(), "places": places}
    for kind in ("weight", "bias"):
        named[f"patches.{kind}"] = published[f"embeddings.patch_embeddings.projection.{kind}"]
        named[f"last.{kind}"] = published[f"layernorm.{kind}"]
        for layer in range(layers):
            ours, theirs = f"layers.{layer}.", f"encoder.layer.{layer}."
            for name, norm in (("before", "norm1"), ("between", "norm2")):
                named[f"{ours}{name}.{kind}"] = published[f"{theirs}{norm}.{kind}"]
            inputs = [published[f"{theirs}attention.attention.{part}.{kind}"] for part in ("query", "key", "value")]
            named[f"{ours}inputs.{kind}"] = torch.cat(inputs)
            named[f"{ours}mlp.0.{kind}"] = published[f"{theirs}mlp.fc1.{kind}"]
            for name, product, scale in (("out", "attention.output.dense", 1), ("mlp.2", "mlp.fc2", 2)):
                factor = published[f"{theirs}layer_scale{scale}.lambda1"]
                value = published[f"{theirs}{product}.{kind}"]
                named[f"{ours}{name}.{kind}"] = value * factor.reshape(-1, *[1] * (value.ndim - 1))
    network.load_state_dict(named)
    return network.eval()


def read_fetched(path: Path) -> dict[str, Tensor]:
    """The weights of the published file by the names that the hub has; two of them lie there under none."""
    held = read_published(path, ("backbone.", *NAMELESS))
    places = torch.cat([held.pop(name) for name in NAMELESS], dim=1)
    return {name.removeprefix("backbone."): value for name, value in held.items()} | {PLACES: places}


def load_dinov2(folder: str, key: str) -> Dinov2:
    """The network of a folder with config.json and model.safetensors; of no folder: of the published file.

    Raises:
        InputError: no weights there, or others; `key`: of the config, e.g. matching.dinov2.path.
    """
    if not folder:
        return fill(read_fetched(find_weights(DINOV2)))
    from safetensors import SafetensorError
    from safetensors.torch import load_file

    check_folder(folder, key)
    try:
        return fill(load_file(Path(folder, "model.safetensors")))
    except (OSError, KeyError, RuntimeError, SafetensorError) as error:
        reason = str(error).splitlines()[0] if str(error) else explain(error)
        what = f"'{folder}' does not load: {reason}"
        raise InputError(key, what, "it should hold a Dinov2Model", code="E-WEIGHTS-BROKEN") from None


class Encoder:
    """DINOv2 on the masked crop, resized without regard to its aspect ratio as in the official code."""

    def __init__(self, options: EncoderOptions) -> None:
        self.options = options.dinov2
        self.network = load_dinov2(self.options.path, "matching.dinov2.path")
        self.width, patch = self.network.last.normalized_shape[0], self.network.patch
        height, width = self.options.height, self.options.width
        if height % patch or width % patch:
            what = f"{height} x {width}: no multiple of {patch}."
            raise InputError("matching.dinov2", what, "e.g. 224", code="E-PATCH-SIZE")
        self.rows, self.columns = height // patch, width // patch

    def settings(self) -> dict[str, Any]:
        """The settings that a feature store depends on."""
        weights = weights_sha256(self.options.path) if self.options.path else DINOV2.sha256
        return {"weights": weights, "height": self.options.height, "width": self.options.width}

    def weights(self, depth: bool) -> NDArray[np.float32]:
        """1 on the features, 0 on the patch position; depth is not used."""
        return np.append(np.ones(self.width), [0, 0]).astype(np.float32)

    def encode(self, views: list[ObjectView]) -> list[Patches]:
        """Foreground patches of each view."""
        return [self._encode(view) for view in views]

    def _encode(self, view: ObjectView) -> Patches:
        grid = (self.rows, self.columns)
        if not view.mask.any():
            return Patches(np.empty((0, self.width), np.float32), np.empty((0, 2), np.float32))
        picture, coverage = masked_square(cut(view), self.options.width, self.options.height)
        pixels = ((picture / np.float32(255) - MEAN) / STD).astype(np.float32)
        with torch.inference_mode():
            tokens = self.network(torch.from_numpy(pixels).permute(2, 0, 1)[None])[0]
        kept = foreground(coverage, *grid)
        return Patches(tokens.reshape(*grid, -1).numpy()[kept], patch_positions(*grid)[kept])
