"""Search `faiss`: the paper's library."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.matching.search import Backward, Rows


def search(queries: NDArray[np.float32], rows: Rows, count: int, both: bool) -> tuple[NDArray[np.float32], Backward]:
    """The same by faiss (the paper's search library)."""
    import faiss

    table, backward = np.empty((len(queries), count), np.float32), []
    for candidate in range(count):
        patches = rows(candidate)
        table[:, candidate] = faiss.knn(queries, patches, 1)[0][:, 0]
        if both:
            backward.append(faiss.knn(patches, queries, 1)[0][:, 0])
    return table, backward
