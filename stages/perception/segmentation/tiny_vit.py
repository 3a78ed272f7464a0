"""TinyViT-5M as MobileSAM's image encoder: convolutions, then attention in windows (Wu et al., TinyViT, ECCV 2022)."""

from functools import partial
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

WIDTHS, DEPTHS, HEADS, WINDOWS = (64, 128, 160, 320), (2, 2, 6, 2), (0, 4, 5, 10), (0, 7, 14, 7)  # of the four stages
EMBEDDING = 256  # numbers per place of what comes out


class ConvNorm(nn.Module):
    """A convolution and its batch normalisation, one convolution once `fuse` was called."""

    def __init__(self, inputs: int, outputs: int, size: int = 1, stride: int = 1, groups: int = 1) -> None:
        super().__init__()
        self.c: Any = nn.Conv2d(inputs, outputs, size, stride, size // 2, groups=groups, bias=False)
        self.bn: Any = nn.BatchNorm2d(outputs)

    def fuse(self) -> None:
        """Fold the normalisation into the convolution."""
        self.c, self.bn = fuse_conv_bn_eval(self.c, self.bn), nn.Identity()

    def forward(self, features: Tensor) -> Tensor:
        """Features (B, outputs, H, W) of features (B, inputs, H, W)."""
        return self.bn(self.c(features))


class Bottleneck(nn.Module):
    """Widen, convolve every channel by itself, narrow; with `shortcut` that is added to the input."""

    def __init__(self, inputs: int, hidden: int, outputs: int, stride: int = 1, shortcut: bool = False) -> None:
        super().__init__()
        self.conv1 = ConvNorm(inputs, hidden)
        self.conv2 = ConvNorm(hidden, hidden, 3, stride, groups=hidden)
        self.conv3 = ConvNorm(hidden, outputs)
        self.shortcut = shortcut

    def forward(self, features: Tensor) -> Tensor:
        """Features (B, outputs, H / stride, W / stride) of features (B, inputs, H, W)."""
        out = self.conv3(functional.gelu(self.conv2(functional.gelu(self.conv1(features)))))
        return functional.gelu(out + features) if self.shortcut else out


class Attention(nn.Module):
    """Attention within a square window; what two places have in common is biased by how far apart they are."""

    apart: Tensor

    def __init__(self, width: int, heads: int, window: int) -> None:
        super().__init__()
        self.heads = heads
        self.norm = nn.LayerNorm(width)
        self.qkv = nn.Linear(width, 3 * width)
        self.proj = nn.Linear(width, width)
        self.attention_biases = nn.Parameter(torch.zeros(heads, window**2))
        row, column = torch.arange(window**2).div(window, rounding_mode="floor"), torch.arange(window**2) % window
        apart = (row[:, None] - row).abs() * window + (column[:, None] - column).abs()
        self.register_buffer("apart", apart, persistent=False)

    def forward(self, windows: Tensor) -> Tensor:
        """Features (B, window^2, width) of features of the same shape."""
        batch, places, _ = windows.shape
        query, key, value = self.qkv(self.norm(windows)).view(batch, places, self.heads, 3, -1).unbind(3)
        query, key, value = (each.transpose(1, 2) for each in (query, key, value))
        bias = self.attention_biases[:, self.apart]  # (heads, places, places)
        mixed = functional.scaled_dot_product_attention(query, key, value, attn_mask=bias[None])
        return self.proj(mixed.transpose(1, 2).reshape(batch, places, -1))


class Mlp(nn.Module):
    """Two layers on every place by itself."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(width)
        self.fc1 = nn.Linear(width, 4 * width)
        self.fc2 = nn.Linear(4 * width, width)

    def forward(self, features: Tensor) -> Tensor:
        """Features (..., width) of features of the same shape."""
        return self.fc2(functional.gelu(self.fc1(self.norm(features))))


class WindowBlock(nn.Module):
    """Attention in windows, a convolution between neighbours, two layers on every place."""

    def __init__(self, width: int, heads: int, window: int) -> None:
        super().__init__()
        self.window = window
        self.attn = Attention(width, heads, window)
        self.local_conv = ConvNorm(width, width, 3, groups=width)
        self.mlp = Mlp(width)

    def forward(self, features: Tensor) -> Tensor:
        """Features (B, width, H, W) of features of the same shape."""
        features = self.local_conv(features + self._attend(features.permute(0, 2, 3, 1)).permute(0, 3, 1, 2))
        return features + self.mlp(features.permute(0, 2, 3, 1)).permute(0, 3, 1, 2)

    def _attend(self, features: Tensor) -> Tensor:
        """What the windows of features (B, H, W, width), padded by 0, give."""
        batch, height, width, channels = features.shape
        size = self.window
        padded = functional.pad(features, (0, 0, 0, -width % size, 0, -height % size))
        rows, columns = padded.shape[1] // size, padded.shape[2] // size
        windows = padded.view(batch, rows, size, columns, size, channels).transpose(2, 3)
        out = self.attn(windows.reshape(-1, size**2, channels)).view(batch, rows, columns, size, size, channels)
        return out.transpose(2, 3).reshape(padded.shape)[:, :height, :width]


class LayerNorm2d(nn.LayerNorm):
    """Layer normalisation over the channels of (B, C, H, W)."""

    def forward(self, features: Tensor) -> Tensor:
        """Features of the same shape."""
        return super().forward(features.permute(0, 2, 3, 1)).permute(0, 3, 1, 2)


class Stage(nn.Module):
    """Blocks and, but for the last stage, what merges patches for the next; modules are named as in the weights."""

    def __init__(self, stage: int) -> None:
        super().__init__()
        width, heads, window = WIDTHS[stage], HEADS[stage], WINDOWS[stage]
        kind: Any = partial(WindowBlock, width, heads, window)
        kind = kind if stage else partial(Bottleneck, width, 4 * width, width, 1, True)
        self.blocks = nn.Sequential(*(kind() for _ in range(DEPTHS[stage])))
        self.downsample: nn.Module = nn.Identity()
        if stage < 3:
            after = WIDTHS[stage + 1]
            self.downsample = Bottleneck(width, after, after, stride=2 if stage < 2 else 1)  # stays at 1/16, as SAM

    def forward(self, features: Tensor) -> Tensor:
        """Features of the next stage."""
        return self.downsample(self.blocks(features))


class TinyViT(nn.Module):
    """A picture (B, 3, 1024, 1024), normalised, to its embedding (B, 256, 64, 64)."""

    def __init__(self) -> None:
        super().__init__()
        first = WIDTHS[0]
        seq = nn.Sequential(ConvNorm(3, first // 2, 3, 2), nn.GELU(), ConvNorm(first // 2, first, 3, 2))
        self.patch_embed = nn.ModuleDict({"seq": seq})
        self.layers = nn.Sequential(*map(Stage, range(4)))
        self.neck = nn.Sequential(
            nn.Conv2d(WIDTHS[-1], EMBEDDING, 1, bias=False),
            LayerNorm2d(EMBEDDING, eps=1e-6),
            nn.Conv2d(EMBEDDING, EMBEDDING, 3, padding=1, bias=False),
            LayerNorm2d(EMBEDDING, eps=1e-6),
        )

    def forward(self, picture: Tensor) -> Tensor:
        """The embedding."""
        return self.neck(self.layers(self.patch_embed["seq"](picture)))

    def fuse(self) -> None:
        """Make it faster, for good: every batch normalisation becomes part of its convolution."""
        for module in self.modules():
            if isinstance(module, ConvNorm):
                module.fuse()
