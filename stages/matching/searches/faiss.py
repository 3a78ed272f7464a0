"""Search `faiss`: the paper's library."""

import numpy as np
from numpy.typing import NDArray

from stages.matching.search import Rows


def search(queries: NDArray[np.float32], rows: Rows, count: int) -> NDArray[np.float32]:
    """The same by faiss (the paper's search library)."""
    import faiss

    table = np.empty((len(queries), count), np.float32)
    for candidate in range(count):
        table[:, candidate] = faiss.knn(queries, rows(candidate), 1)[0][:, 0]
    return table
