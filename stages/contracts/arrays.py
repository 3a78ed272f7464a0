"""Read numpy and HDF5 files that pass between stages: whatever is wrong with one becomes an `InputError`."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import files
from roomkin.stages.contracts.errors import InputError, explain, file_missing

if TYPE_CHECKING:
    import h5py

MAX_BYTES = 2_000_000_000  # of a file of arrays or meshes, unpacked
BLOCK = 4_000_000  # numbers looked at in one go


@contextmanager
def explain_unreadable(path: Path, what: str, fix: str = "") -> Iterator[None]:
    """Around the opening and decoding of a file, for which the libraries raise many kinds of exception."""
    check_file(path, fix)
    try:
        yield
    except InputError:
        raise
    except FileNotFoundError:
        raise file_missing(path, fix) from None
    except UnicodeDecodeError:
        raise InputError(path, "is no UTF-8 text.", "save it as UTF-8", code="E-FILE-ENCODING") from None
    except json.JSONDecodeError as error:
        what = f"is no readable {what}: it is no JSON in line {error.lineno}."
        raise InputError(path, what, fix, code="E-FILE-UNREADABLE") from None
    except Exception as error:
        raise InputError(path, f"is no readable {what} ({explain(error)}).", fix, code="E-FILE-UNREADABLE") from None


def check_file(path: Path, fix: str = "") -> None:
    """Refuse what is there and would be read for ever, or fill the memory.

    Raises:
        InputError: a folder, a pipe or a device, or more than `MAX_BYTES`.
    """
    files.check_file(path, fix)
    if path.exists() and (size := path.stat().st_size) > MAX_BYTES:
        raise InputError(path, f"has {size / 1e9:.1f} GB.", fix, code="E-FILE-LARGE")


def read_npz(path: Path, fix: str = "") -> dict[str, NDArray[Any]]:
    """All arrays of an npz file.

    Raises:
        InputError: it is missing, broken, holds pickled objects, or would fill the memory.
    """
    with explain_unreadable(path, "npz file", fix), np.load(path, allow_pickle=False) as arrays:
        size = sum(entry.file_size for entry in arrays.zip.infolist())
        if size > MAX_BYTES:
            raise InputError(path, f"unpacks to {size / 1e9:.1f} GB.", fix, code="E-FILE-LARGE")
        return {name: arrays[name] for name in arrays.files}


def dataset(path: Path, group: "h5py.Group", name: str, fix: str = "") -> "h5py.Dataset":
    """A dataset of an HDF5 file, not read yet."""
    import h5py

    found = group.get(name)
    if not isinstance(found, h5py.Dataset):
        raise InputError(path, f"has no array '{group.name.strip('/')}/{name}'.", fix, code="E-ARRAY-MISSING")
    return found


def check_array(
    where: object, name: str, array: Any, shape: tuple[int | str, ...], kinds: str = "f", fix: str = ""
) -> None:
    """Refuse an array (or dataset) of another type or shape; a letter in `shape` stands for any length.

    `kinds` are numpy's: f float, u and i whole numbers, b bool.
    """
    if array.dtype.kind not in kinds:
        raise InputError(where, f"{name}: has type {array.dtype}.", fix, code="E-ARRAY-TYPE")
    fits = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or length == wanted for length, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join(map(str, shape))
        raise InputError(where, f"{name}: has shape {tuple(array.shape)}, not ({wanted}).", fix, code="E-ARRAY-SHAPE")


def check_within(where: object, name: str, array: Any, low: float, high: float, fix: str = "") -> None:
    """Refuse values that are not finite or not between two bounds. Large arrays are looked at part by part."""
    rows = max(1, BLOCK // max(1, int(np.prod(array.shape[1:]))))
    for start in range(0, len(array), rows):
        part = np.asarray(array[start : start + rows])
        if not np.isfinite(part).all():
            raise InputError(where, f"{name}: holds NaN or infinity.", fix, code="E-ARRAY-VALUES")
        if part.size and (part.min() < low or part.max() > high):
            worst = float(part.min() if part.min() < low else part.max())
            what = f"{name}: holds {worst:g}, which is not within {low:g} and {high:g}."
            raise InputError(where, what, fix, code="E-ARRAY-VALUES")
