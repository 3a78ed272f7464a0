"""robomimic HDF5: several stores in one file, with the filter keys train, valid and one per asset."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from roomkin.stages.contracts import write_atomically
from roomkin.stages.contracts.episode_store import read_episodes

VALIDATION = 10  # every n-th episode


def write(stores: Sequence[Path], out: Path, library: Path | None) -> None:
    """Write `demonstrations.hdf5` into the folder `out`; its attributes are those of the first store."""
    masks: dict[str, list[str]] = defaultdict(list)
    total = 0
    with (
        write_atomically(out / "demonstrations.hdf5") as temporary,
        h5py.File(temporary, "w", track_order=True) as file,
    ):
        data = file.create_group("data", track_order=True)
        for path in stores:
            assets = read_episodes(path).assets  # refuses what is broken
            with h5py.File(path, "r") as source:
                for key, value in source["data"].attrs.items():
                    data.attrs.setdefault(key, value)
                for index, asset in enumerate(assets):
                    number = len(data)
                    source.copy(source[f"data/demo_{index}"], data, name=f"demo_{number}")
                    demo = data[f"demo_{number}"]
                    last = np.arange(len(demo["actions"])) == len(demo["actions"]) - 1
                    for name, dtype in (("rewards", np.float32), ("dones", np.uint8)):
                        if name not in demo:  # a store that another command wrote need not have them
                            demo.create_dataset(name, data=last.astype(dtype), track_times=False)
                    demo.attrs["num_samples"] = len(last)
                    total += len(last)
                    for mask in ("valid" if number % VALIDATION == VALIDATION - 1 else "train", asset):
                        masks[mask].append(f"demo_{number}")
        data.attrs["total"] = total
        for mask, names in sorted(masks.items()):
            file.create_dataset(f"mask/{mask}", data=np.array(names, "S"), track_times=False)
