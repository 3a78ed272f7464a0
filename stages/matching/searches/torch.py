"""Search `torch`: matrix products."""

import numpy as np
from numpy.typing import NDArray

from stages.matching.search import Backward, Rows


def search(queries: NDArray[np.float32], rows: Rows, count: int, both: bool) -> tuple[NDArray[np.float32], Backward]:
    """Squared distances by one matrix product per picture: |q - r|^2 = |q|^2 - 2 q.r + |r|^2."""
    import torch

    table, backward = np.empty((len(queries), count), np.float32), []
    query = torch.from_numpy(np.ascontiguousarray(queries))
    length = (query * query).sum(1)
    for candidate in range(count):
        patches = torch.from_numpy(rows(candidate))
        products = torch.addmm((patches * patches).sum(1), query, patches.T, alpha=-2)
        table[:, candidate] = (products.amin(1) + length).numpy()
        if both:
            backward.append((products + length[:, None]).amin(0).numpy())
    return table, backward
