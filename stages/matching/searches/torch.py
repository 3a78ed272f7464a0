"""Search `torch`: matrix products, by oneDNN where there is one (twice as fast as MKL on AMD: docs/benchmarks.md)."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from roomkin.stages.matching.search import Backward, Rows

ONEDNN = torch.backends.mkldnn.is_available() and hasattr(torch.ops.mkldnn, "_linear_pointwise")
BLOCK = 512  # query patches per product, which then stays in the cache until its minima are taken; chosen


def search(queries: NDArray[np.float32], rows: Rows, count: int, both: bool) -> tuple[NDArray[np.float32], Backward]:
    """Squared distances by one matrix product per picture: |q - r|^2 = |q|^2 - 2 q.r + |r|^2."""
    table, backward = np.empty((len(queries), count), np.float32), []
    query = torch.from_numpy(np.ascontiguousarray(queries))
    length = (query * query).sum(1)
    for candidate in range(count):
        patches = torch.from_numpy(rows(candidate))
        weight, bias = -2 * patches, (patches * patches).sum(1)
        nearest, nearest_query = [], torch.full((len(patches),), torch.inf)
        for block, own in zip(query.split(BLOCK), length.split(BLOCK), strict=True):
            products = affine(block, weight, bias)
            nearest.append(products.amin(1) + own)
            if both:
                nearest_query = torch.minimum(nearest_query, (products + own[:, None]).amin(0))
        table[:, candidate] = torch.cat(nearest).numpy()
        if both:
            backward.append(nearest_query.numpy())
    return table, backward


def affine(inputs: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """inputs (N, D) times weight (M, D) transposed, plus bias (M,)."""
    if ONEDNN:
        result: Tensor = torch.ops.mkldnn._linear_pointwise(inputs, weight, bias, "none", [], "")
        return result
    return torch.nn.functional.linear(inputs, weight, bias)
