"""MobileSAM: the outline of what lies at a point or in a box (Zhang et al., Faster Segment Anything, 2023)."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from torch import Tensor, nn

from roomkin.stages.config.perception import OutlineSection
from roomkin.stages.config.weights import MOBILE_SAM, find_weights
from roomkin.stages.contracts import InputError
from roomkin.stages.perception.segmentation.decoder import SIDE, MaskDecoder, PromptEncoder
from roomkin.stages.perception.segmentation.proposal import Mask, Proposal, RoomView
from roomkin.stages.perception.segmentation.tiny_vit import TinyViT

INPUT = 1024  # pixels of the longer side, as trained
GRID = 4  # pixels of the input per pixel of a mask
MEAN, SPREAD = (123.675, 116.28, 103.53), (58.395, 57.12, 57.375)  # of ImageNet's RGB, as trained
BATCH = 4  # prompts at a time; chosen: the fastest on a CPU, as all of it stays near the core
SURE = 1.0  # logits; how far the threshold moves in `stability` (Segment Anything, section 5)
UNUSED = ("image_encoder.norm_head.", "image_encoder.head.", "prompt_encoder.mask_downscaling.")  # weights
MOST = 120  # clicks; chosen for time
AT_ONCE = 12  # clicks between two looks at what is left; chosen
MIN_REACH = 2.5  # pixels of an outline, from a click to what needs none; chosen
AROUND = 3  # pixels around a click that need no further one
SCORE, STABILITY = 0.7, 0.75  # least ones of an outline that is proposed; chosen
COVERS = 0.8  # least of both of an outline that covers, so that nothing inside is clicked; chosen


class Outlines(NamedTuple):
    """Three guesses for each of N prompts.

    Attributes:
        logits: (N, 3, h, w) float16, above 0 inside; h, w: the picture with a longer side of 256.
        scores: (N, 3) IoU with the thing meant, as the network guesses.
        stability: (N, 3) share of the pixels with a logit above -1 that have one above 1.
    """

    logits: NDArray[np.float16]
    scores: NDArray[np.float32]
    stability: NDArray[np.float32]


class _Network(nn.Module):
    """The three parts by their names in the weights."""

    def __init__(self) -> None:
        super().__init__()
        self.image_encoder, self.prompt_encoder, self.mask_decoder = TinyViT(), PromptEncoder(), MaskDecoder()


class MobileSam:
    """The network with its published weights."""

    def __init__(self, path: Path | None = None) -> None:
        """Load the weights.

        Raises:
            InputError: they are not there, or others.
        """
        path = path or find_weights(MOBILE_SAM)
        weights = torch.load(path, map_location="cpu", weights_only=True)
        self._network = _Network()
        used = {name: value for name, value in weights.items() if not name.startswith(UNUSED)}
        try:
            self._network.load_state_dict(used)
        except RuntimeError as error:
            what = f"holds other weights: {error}"
            raise InputError(path, what, "remove it and fetch it again", code="E-WEIGHTS-OTHER") from None
        self._network.eval().requires_grad_(False)
        self._network.image_encoder.fuse()
        self._network.image_encoder.to(memory_format=torch.channels_last)
        self._places = self._network.prompt_encoder.places()

    @torch.inference_mode()
    def embed(self, rgb: NDArray[np.uint8]) -> "Embedded":
        """Look at a picture (H, W, 3), once for all prompts."""
        height, width = rgb.shape[:2]
        scale = INPUT / max(height, width)
        size = (int(height * scale + 0.5), int(width * scale + 0.5))
        resized = Image.fromarray(rgb).resize(size[::-1], Image.Resampling.BILINEAR)
        padded = np.zeros((INPUT, INPUT, 3), np.float32)
        padded[: size[0], : size[1]] = (np.asarray(resized, np.float32) - MEAN) / SPREAD
        features = self._network.image_encoder(torch.from_numpy(padded).permute(2, 0, 1)[None])
        return Embedded(self._network, self._places, features, (height, width), size)


@dataclass(frozen=True, repr=False, eq=False)
class Embedded:
    """A picture as the network has seen it, to be asked."""

    _network: _Network
    _places: Tensor
    _features: Tensor
    shape: tuple[int, int]
    _size: tuple[int, int]  # of the resized picture

    @property
    def features(self) -> NDArray[np.float32]:
        """(256, 64, 64): the embedding of the padded picture."""
        return self._features[0].numpy()

    def outline_points(self, points: ArrayLike) -> Outlines:
        """What lies at each of some points (N, 2), x and y in pixels."""
        return self._outline(self._network.prompt_encoder.points(self._fractions(points, 2)))

    def outline_clicks(self, points: ArrayLike, inside: ArrayLike) -> Outlines:
        """The one thing that points (K, 2), x and y in pixels, say together: each lies inside it, or outside, (K,)."""
        kinds = torch.from_numpy(np.asarray(inside, np.int64))
        return self._outline(self._network.prompt_encoder.clicks(self._fractions(points, 2), kinds))

    def outline_boxes(self, boxes: ArrayLike) -> Outlines:
        """What lies in each of some boxes (N, 4), x0, y0, x1, y1 in pixels."""
        return self._outline(self._network.prompt_encoder.boxes(self._fractions(boxes, 4)))

    def upsample(self, logits: NDArray[np.float16]) -> NDArray[np.bool_]:
        """A mask (h, w) of logits at the size of the picture, (H, W)."""
        scale = INPUT / GRID / max(self.shape)
        matrix = np.array([[scale, 0, scale / 2 - 0.5], [0, scale, scale / 2 - 0.5]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = self.shape[::-1]
        finer = cv2.warpAffine(logits.astype(np.float32), matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(finer > 0)

    def _fractions(self, pixels: ArrayLike, columns: int) -> Tensor:
        """x and y of N points or boxes as parts of the padded input."""
        found = np.asarray(pixels, float).reshape(-1, columns // 2, 2)
        resized = found * np.divide(self._size[::-1], self.shape[::-1])
        return torch.tensor((resized + 0.5) / INPUT, dtype=torch.float32).view(-1, columns)

    @torch.inference_mode()
    def _outline(self, tokens: Tensor) -> Outlines:
        """The outlines of prompts (N, 2, 256)."""
        network = self._network
        height, width = (math.ceil(side / GRID) for side in self._size)
        filled = tuple(math.ceil(side * SIDE / INPUT) for side in self._size)
        picture = (self._features + network.prompt_encoder.no_mask_embed.weight.view(1, -1, 1, 1)).flatten(2).mT
        found = []
        for some in tokens.split(BATCH):
            logits, scores = network.mask_decoder(some, picture, self._places, filled)
            logits = logits[..., :height, :width]
            stability = (logits > SURE).sum((-2, -1)) / (logits > -SURE).sum((-2, -1)).clamp(min=1)
            found.append((logits.half().numpy(), scores.numpy(), stability.numpy()))
        return Outlines(*(np.concatenate(part) for part in zip(*found, strict=True)))


def propose(view: RoomView, options: OutlineSection) -> list[Proposal]:
    """Three outlines a click, as far as they are good; the smallest good one covers, so that parts are clicked too."""
    rest = view.shrink(~view.surfaces.floor & ~view.border)
    found: list[Proposal] = []
    for _ in range(MOST // AT_ONCE):
        clicks = choose_clicks(rest, AT_ONCE)
        if not clicks:
            break
        scale = max(view.depth.shape) / max(rest.shape)
        outlines = view.embedded.outline_points((np.array(clicks) + 0.5) * scale - 0.5)
        for (x, y), *guesses in zip(clicks, *outlines, strict=True):
            rest[max(0, y - AROUND) : y + AROUND + 1, max(0, x - AROUND) : x + AROUND + 1] = False
            cover: Mask | None = None
            for logits, score, stability in zip(*guesses, strict=True):
                if score < SCORE or stability < STABILITY:
                    continue
                found.append(Proposal(logits, float(score * stability), "mobile_sam"))
                mask = found[-1].mask
                if min(score, stability) >= COVERS and (cover is None or mask.sum() < cover.sum()):
                    cover = mask
            if cover is not None:
                rest &= ~cover
    return found


def choose_clicks(rest: Mask, count: int) -> list[tuple[int, int]]:
    """Up to `count` pixels (x, y) in the middle of what is left (h, w), the widest places first, apart."""
    left, clicks = np.pad(rest, 1).astype(np.uint8), []
    for _ in range(count):
        reach = cv2.distanceTransform(left, cv2.DIST_L2, 3)
        y, x = np.unravel_index(int(reach.argmax()), reach.shape)
        if reach[y, x] < MIN_REACH:
            break
        clicks.append((int(x) - 1, int(y) - 1))
        cv2.circle(left, (int(x), int(y)), max(2 * AROUND, round(float(reach[y, x]))), 0, -1)
    return clicks
