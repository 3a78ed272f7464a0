"""One array of a file of numpy's, whatever empty axes a simulator leaves around it."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.arrays import read_npz

ARRAYS = (".npy", ".npz")


def read_array(path: Path, name: str) -> NDArray[Any]:
    """The array of an NPY file, or the one of this name or the only one of an NPZ file, without axes of length 1.

    Raises:
        InputError: several arrays, none of which is called so.
    """
    if path.suffix.lower() == ".npy":
        return np.squeeze(np.asarray(np.load(path, allow_pickle=False)))
    arrays = read_npz(path)
    if name not in arrays and len(arrays) != 1:
        what = f"holds {', '.join(arrays)}, and none of them is called {name}."
        fix = f"store one array (height, width) of numbers, called {name}"
        raise InputError(path, what, fix, code="E-ARRAY-MISSING")
    return np.squeeze(arrays.get(name, next(iter(arrays.values()))))
