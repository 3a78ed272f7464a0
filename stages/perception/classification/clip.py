"""CLIP's image tower (Radford et al. 2021), ViT-B/16: what a picture of a thing looks like, as a vector.

The published file holds weights of eight bits; they are made floats again, so that every machine gives the same.
"""

from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from roomkin.stages.config.weights import CLIP, FOLDER, find_weights
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.masks import GREY, pixel_bounds

SIZE, PATCH, WIDTH, LAYERS, HEADS, EMBEDDED = 224, 16, 768, 12, 12, 512
MEAN, SPREAD = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)
MARGIN, BLUR, DIM = 1.2, 0.05, 0.5  # times a mask's box; of that: how far what is around is blurred; greyed so much
BATCH = 16
Picture = NDArray[np.uint8]


class QuickGelu(nn.Module):
    """x * sigmoid(1.702 x), as OpenAI's networks have it."""

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        return x * torch.sigmoid(1.702 * x)


class Layer(nn.Module):
    """A vision transformer's: attention and a perceptron, each of what is normalised before it, and added to it."""

    def __init__(self, width: int, heads: int, activation: nn.Module, epsilon: float = 1e-5) -> None:
        super().__init__()
        self.heads = heads
        self.before = nn.LayerNorm(width, epsilon)
        self.inputs, self.out = nn.Linear(width, 3 * width), nn.Linear(width, width)
        self.between = nn.LayerNorm(width, epsilon)
        self.mlp = nn.Sequential(nn.Linear(width, 4 * width), activation, nn.Linear(4 * width, width))

    def forward(self, x: Tensor) -> Tensor:
        """(B, T, width) -> the same."""
        query, key, value = self.inputs(self.before(x)).unflatten(-1, (3, self.heads, -1)).permute(2, 0, 3, 1, 4)
        seen = nn.functional.scaled_dot_product_attention(query, key, value)
        x = x + self.out(seen.transpose(1, 2).flatten(2))
        return x + self.mlp(self.between(x))


class Tower(nn.Module):
    """Pictures (B, 3, 224, 224) -> embeddings (B, 512)."""

    def __init__(self) -> None:
        super().__init__()
        self.patches = nn.Conv2d(3, WIDTH, PATCH, PATCH, bias=False)
        self.whole = nn.Parameter(torch.zeros(WIDTH))
        self.places = nn.Parameter(torch.zeros((SIZE // PATCH) ** 2 + 1, WIDTH))
        self.first, self.last = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        self.layers = nn.Sequential(*(Layer(WIDTH, HEADS, QuickGelu()) for _ in range(LAYERS)))
        self.project = nn.Linear(WIDTH, EMBEDDED, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        """See the class."""
        patches = self.patches(x).flatten(2).transpose(1, 2)
        tokens = torch.cat([self.whole.expand(len(x), 1, -1), patches], dim=1) + self.places
        found: Tensor = self.project(self.last(self.layers(self.first(tokens))[:, 0]))
        return found


def read_published(path: Path, part: str | tuple[str, ...] = "vision_model.") -> dict[str, Tensor]:
    """The weights of an ONNX file's transformer, also of layers that are quantised to eight bits, by published names.

    Args:
        part: what the names of its weights begin with, but those of products.
    """
    import onnx
    from onnx import numpy_helper

    graph = onnx.load(path).graph
    held = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    readers: dict[str, list[Any]] = {}
    for node in graph.node:
        for name in node.input:
            readers.setdefault(name, []).append(node)

    def name_of(result: str) -> str:
        """Whose weights a product's are, by the bias that is added to it; the last product has none."""
        while readers.get(result):
            for node in readers[result]:
                for bias in node.input:
                    if node.op_type == "Add" and bias in held and bias.endswith(".bias"):
                        return bias.removesuffix("bias") + "weight"
            result = next((node.output[0] for node in readers[result] if node.op_type in ("Cast", "Mul")), "")
        return "visual_projection.weight"

    found = {name: value for name, value in held.items() if name.startswith(part)}
    for node in graph.node:
        if node.op_type == "MatMul" and node.input[1] in held:
            found[name_of(node.output[0])] = held[node.input[1]].T
        if node.op_type == "MatMulInteger":
            whole, zero = held[node.input[1]].astype(np.float32), held[node.input[3]].astype(np.float32)
            scale = held[node.input[1].replace("_quantized", "_scale")]
            found[name_of(node.output[0])] = ((whole - zero) * scale).T
    return {name: torch.from_numpy(np.array(value, np.float32)) for name, value in found.items()}


def fill(tower: Tower, published: dict[str, Tensor]) -> Tower:
    """The tower with weights by the names that they are published under."""
    model = "vision_model."
    named = {
        "patches.weight": published[model + "embeddings.patch_embedding.weight"],
        "whole": published[model + "embeddings.class_embedding"].flatten(),
        "places": published[model + "embeddings.position_embedding.weight"].reshape(-1, WIDTH),
        "project.weight": published["visual_projection.weight"],
    }
    for ours, theirs in (("first", "pre_layrnorm"), ("last", "post_layernorm")):
        named |= {f"{ours}.{kind}": published[f"{model}{theirs}.{kind}"] for kind in ("weight", "bias")}
    names = {"before": "layer_norm1", "between": "layer_norm2", "out": "self_attn.out_proj"}
    names |= {"mlp.0": "mlp.fc1", "mlp.2": "mlp.fc2"}
    for layer in range(LAYERS):
        own = f"{model}encoder.layers.{layer}."
        for kind in ("weight", "bias"):
            named |= {f"layers.{layer}.{ours}.{kind}": published[f"{own}{name}.{kind}"] for ours, name in names.items()}
            inputs = [published[f"{own}self_attn.{part}_proj.{kind}"] for part in "qkv"]
            named[f"layers.{layer}.inputs.{kind}"] = torch.cat(inputs)
    tower.load_state_dict(named)
    return tower.eval()


@cache
def _read_tower(folder: Path) -> Tower:
    return fill(Tower(), read_published(find_weights(CLIP, folder)))


def load_tower(folder: Path = FOLDER) -> Tower | None:
    """The tower; None: its weights are not here."""
    try:
        return _read_tower(folder)
    except InputError:
        return None


def show(rgb: Picture, mask: NDArray[np.bool_]) -> Picture:
    """A square picture (SIZE, SIZE, 3) of a mask (H, W) and a little around it, which is blurred towards grey."""
    x0, y0, x1, y1 = pixel_bounds(mask)
    side = max(2, round(MARGIN * max(x1 - x0, y1 - y0)))
    left, top = (x0 + x1 - side) // 2, (y0 + y1 - side) // 2
    reach = max(0, -left, -top, left + side - mask.shape[1], top + side - mask.shape[0])
    window = (slice(top + reach, top + reach + side), slice(left + reach, left + reach + side))
    seen = np.pad(rgb, [(reach, reach)] * 2 + [(0, 0)], constant_values=GREY)[window]
    shown = np.pad(mask, reach)[window]
    blurred = cv2.GaussianBlur(seen, (0, 0), max(2.0, BLUR * side))
    around = np.rint(DIM * blurred + (1 - DIM) * GREY).astype(np.uint8)
    method = cv2.INTER_AREA if side > SIZE else cv2.INTER_CUBIC
    square = np.where(shown[..., None], seen, around)
    return np.asarray(cv2.resize(square, (SIZE, SIZE), interpolation=method), np.uint8)


def embed(tower: Tower, pictures: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Unit vectors (N, EMBEDDED) of pictures (N, SIZE, SIZE, 3)."""
    mean, spread = (torch.tensor(each)[:, None, None] for each in (MEAN, SPREAD))
    device = tower.whole.device
    found = []
    with torch.inference_mode():
        for some in torch.from_numpy(pictures).split(BATCH):
            inputs = (some.permute(0, 3, 1, 2).float() / 255 - mean) / spread
            found.append(nn.functional.normalize(tower(inputs.to(device)), dim=1).cpu())
    return torch.cat(found).numpy() if found else np.zeros((0, EMBEDDED), np.float32)
