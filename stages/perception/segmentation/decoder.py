"""SAM's prompts and mask decoder, for many prompts on one picture (Kirillov et al., Segment Anything, ICCV 2023).

Modules are named as in the published weights. Of a picture's 4096 places only the few prompt tokens are projected where
attention allows it: q . (K x) = (K' q) . x, and a mean of projections is the projection of the mean. That is exact, and
halves the work.
"""

import math
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

WIDTH, HEADS, SIDE = 256, 8, 64  # numbers per token; heads; places along a side of the picture's embedding
MASKS = 3  # guesses for one prompt: whole, part, part of a part


class TokenAttention(nn.Module):
    """Attention between a prompt's few tokens and the many places of a picture, or among the tokens."""

    def __init__(self, inner: int) -> None:
        super().__init__()
        self.q_proj, self.k_proj, self.v_proj = (nn.Linear(WIDTH, inner) for _ in range(3))
        self.out_proj = nn.Linear(inner, WIDTH)

    def forward(self, query: Tensor, key: Tensor, value: Tensor) -> Tensor:
        """Among tokens (N, T, WIDTH)."""
        query, key, value = _split(self.q_proj(query)), _split(self.k_proj(key)), _split(self.v_proj(value))
        return self.out_proj(functional.scaled_dot_product_attention(query, key, value).transpose(1, 2).flatten(2))

    def to_picture(self, query: Tensor, key: Tensor, value: Tensor) -> Tensor:
        """What tokens (N, T, WIDTH) take from places (N or 1, P, WIDTH). The bias of keys changes no weight."""
        query = _split(self.q_proj(query))  # (N, HEADS, T, inner / HEADS)
        towards = (query @ self.k_proj.weight.view(HEADS, -1, WIDTH)).flatten(1, 2) / math.sqrt(query.shape[-1])
        mean = (towards @ key.mT).softmax(-1) @ value  # (N, HEADS * T, WIDTH)
        taken = mean.unflatten(1, (HEADS, -1)) @ self.v_proj.weight.view(HEADS, -1, WIDTH).mT
        return self.out_proj(taken.transpose(1, 2).flatten(2) + self.v_proj.bias)

    def from_picture(self, query: Tensor, key: Tensor, value: Tensor) -> Tensor:
        """What places (N or 1, P, WIDTH) take from tokens (N, T, WIDTH)."""
        key, value = _split(self.k_proj(key)), _split(self.v_proj(value))
        key = key / math.sqrt(key.shape[-1])
        towards = (key @ self.q_proj.weight.view(HEADS, -1, WIDTH)).flatten(1, 2)  # (N, HEADS * T, WIDTH)
        bias = (key @ self.q_proj.bias.view(HEADS, -1, 1)).flatten(1, 2)  # (N, HEADS * T, 1)
        shares = (towards @ query.mT + bias).unflatten(1, (HEADS, -1)).softmax(2).flatten(1, 2)
        given = (value @ self.out_proj.weight.T.view(HEADS, -1, WIDTH)).flatten(1, 2)
        return shares.mT @ given + self.out_proj.bias


def _split(tokens: Tensor) -> Tensor:
    """(N, T, C) to (N, HEADS, T, C / HEADS)."""
    return tokens.unflatten(-1, (HEADS, -1)).transpose(1, 2)


class TwoWayLayer(nn.Module):
    """Tokens look at each other and at the picture, then the picture at the tokens."""

    def __init__(self, first: bool) -> None:
        super().__init__()
        self.first = first
        self.self_attn = TokenAttention(WIDTH)
        self.cross_attn_token_to_image = TokenAttention(WIDTH // 2)
        self.cross_attn_image_to_token = TokenAttention(WIDTH // 2)
        self.mlp = nn.ModuleDict({"lin1": nn.Linear(WIDTH, 8 * WIDTH), "lin2": nn.Linear(8 * WIDTH, WIDTH)})
        self.norm1, self.norm2, self.norm3, self.norm4 = (nn.LayerNorm(WIDTH) for _ in range(4))

    def forward(self, tokens: Tensor, picture: Tensor, prompt: Tensor, places: Tensor) -> tuple[Tensor, Tensor]:
        """Tokens (N, T, WIDTH) and picture (N or 1, P, WIDTH) anew; `prompt`, `places`: what says where they are."""
        asked = tokens if self.first else tokens + prompt
        tokens = self.norm1(self.self_attn(asked, asked, tokens) + (0 if self.first else tokens))
        seen = self.cross_attn_token_to_image.to_picture(tokens + prompt, picture + places, picture)
        tokens = self.norm2(tokens + seen)
        tokens = self.norm3(tokens + self.mlp["lin2"](self.mlp["lin1"](tokens).relu()))
        taken = self.cross_attn_image_to_token.from_picture(picture + places, tokens + prompt, tokens)
        return tokens, self.norm4(picture + taken)


class TwoWayTransformer(nn.Module):
    """Two such layers, and a last look of the tokens at the picture."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleList([TwoWayLayer(True), TwoWayLayer(False)])
        self.final_attn_token_to_image = TokenAttention(WIDTH // 2)
        self.norm_final_attn = nn.LayerNorm(WIDTH)

    def forward(self, prompt: Tensor, picture: Tensor, places: Tensor) -> tuple[Tensor, Tensor]:
        """Tokens (N, T, WIDTH) and picture (N, P, WIDTH)."""
        tokens = prompt
        for layer in self.layers:
            tokens, picture = layer(tokens, picture, prompt, places)
        taken = self.final_attn_token_to_image.to_picture(tokens + prompt, picture + places, picture)
        return self.norm_final_attn(tokens + taken), picture


class Layers(nn.Module):
    """Three layers on a token."""

    def __init__(self, outputs: int) -> None:
        super().__init__()
        self.layers = nn.ModuleList([nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, outputs)])

    def forward(self, token: Tensor) -> Tensor:
        """(..., outputs) of (..., WIDTH)."""
        for layer in self.layers[:-1]:
            token = layer(token).relu()
        return self.layers[-1](token)


class MaskDecoder(nn.Module):
    """Masks of prompts on a picture, four times as fine as its embedding."""

    def __init__(self) -> None:
        super().__init__()
        self.transformer = TwoWayTransformer()
        self.iou_token, self.mask_tokens = nn.Embedding(1, WIDTH), nn.Embedding(1 + MASKS, WIDTH)
        self.output_upscaling = nn.Sequential(
            nn.ConvTranspose2d(WIDTH, WIDTH // 4, 2, 2),
            nn.LayerNorm(WIDTH // 4, eps=1e-6),
            nn.GELU(),
            nn.ConvTranspose2d(WIDTH // 4, WIDTH // 8, 2, 2),
        )
        self.output_hypernetworks_mlps = nn.ModuleList([Layers(WIDTH // 8) for _ in range(1 + MASKS)])
        self.iou_prediction_head = Layers(1 + MASKS)

    def forward(self, prompts: Tensor, picture: Tensor, places: Tensor, size: tuple[int, int]) -> tuple[Tensor, Tensor]:
        """Logits (N, MASKS, 4 rows, 4 columns) and guessed IoU (N, MASKS).

        Args:
            prompts: (N, T, WIDTH) tokens.
            picture: (1, SIDE^2, WIDTH) its embedding.
            places: (1, SIDE^2, WIDTH) what says where they are.
            size: rows and columns of places that the picture fills.
        """
        own = torch.cat([self.iou_token.weight, self.mask_tokens.weight]).expand(len(prompts), -1, -1)
        tokens, picture = self.transformer(torch.cat([own, prompts], 1), picture, places)
        kernels = [mlp(tokens[:, 2 + k]) for k, mlp in enumerate(self.output_hypernetworks_mlps[1:])]
        filled = picture.unflatten(1, (SIDE, SIDE))[:, : size[0], : size[1]].flatten(1, 2)
        masks = torch.stack(kernels, 1) @ self._upscale(filled).mT  # (N, MASKS, rows * columns * 2 * 2 * 2 * 2)
        masks = masks.unflatten(2, (*size, 2, 2, 2, 2)).permute(0, 1, 2, 4, 6, 3, 5, 7)
        masks = masks.reshape(*masks.shape[:2], 4 * size[0], 4 * size[1])
        return masks, self.iou_prediction_head(tokens[:, 0])[:, 1:]

    def _upscale(self, picture: Tensor) -> Tensor:
        """Places (N, P, WIDTH) made four times as fine: (N, P * 2 * 2 * 2 * 2, WIDTH / 8).

        As products of matrices, for the kernels of these transposed convolutions do not overlap.
        """
        first, norm, _, second = self.output_upscaling
        finer = functional.gelu(norm(_refine(picture, first)))
        return functional.gelu(_refine(finer, second))


def _refine(picture: Tensor, finer: Any) -> Tensor:
    """Four places (N, 4 P, outputs) of each (N, P, inputs), by rows, by a transposed convolution of 2 x 2, stride 2."""
    weight = finer.weight.permute(2, 3, 1, 0).flatten(0, 2)
    return functional.linear(picture, weight, finer.bias.repeat(4)).unflatten(2, (4, -1)).flatten(1, 2)


class PromptEncoder(nn.Module):
    """Points and boxes as tokens, by random Fourier features of where they are."""

    def __init__(self) -> None:
        super().__init__()
        self.pe_layer = nn.ParameterDict({"positional_encoding_gaussian_matrix": torch.zeros(2, WIDTH // 2)})
        # Outside, inside, corners.
        self.point_embeddings: Any = nn.ModuleList([nn.Embedding(1, WIDTH) for _ in range(4)])
        self.not_a_point_embed, self.no_mask_embed = nn.Embedding(1, WIDTH), nn.Embedding(1, WIDTH)

    def locate(self, points: Tensor) -> Tensor:
        """(..., WIDTH) of points (..., 2), x and y from 0 to 1 across the padded picture."""
        angles = 2 * math.pi * ((2 * points - 1) @ self.pe_layer["positional_encoding_gaussian_matrix"])
        return torch.cat([angles.sin(), angles.cos()], -1)

    def places(self) -> Tensor:
        """(1, SIDE^2, WIDTH) of the places of a picture's embedding, by rows."""
        middles = (torch.arange(SIDE) + 0.5) / SIDE
        return self.locate(torch.stack(torch.meshgrid(middles, middles, indexing="xy"), -1)).view(1, -1, WIDTH)

    def points(self, points: Tensor) -> Tensor:
        """Tokens (N, 2, WIDTH) of points (N, 2) that lie inside a thing; the second stands for no box."""
        inside = self.locate(points) + self.point_embeddings[1].weight
        return torch.stack([inside, self.not_a_point_embed.weight.expand_as(inside)], 1)

    def clicks(self, points: Tensor, inside: Tensor) -> Tensor:
        """Tokens (1, K + 1, WIDTH) of K points (K, 2) of one thing: `inside` (K,) it, 1, or outside, 0."""
        kinds = torch.cat([kind.weight for kind in self.point_embeddings[:2]])
        return torch.cat([self.locate(points) + kinds[inside], self.not_a_point_embed.weight])[None]

    def boxes(self, boxes: Tensor) -> Tensor:
        """Tokens (N, 2, WIDTH) of boxes (N, 4), x0, y0, x1, y1."""
        corners = torch.cat([self.point_embeddings[2].weight, self.point_embeddings[3].weight])
        return self.locate(boxes.view(-1, 2, 2)) + corners
