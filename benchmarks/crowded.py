"""How generation's steps after the fit grow with the number of things: stack and push apart.

    python -m benchmarks.crowded [--things 11 22]

Models of the library at random places of a room as crowded as few are, whose area grows with their number: one thing a
square metre, of which many overlap. CPU seconds of one thread, the mean over rooms.
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.tables import table
from stages.config.generation import GenerationConfig
from stages.contracts import Asset, read_json
from stages.contracts.library_folder import AssetFolders
from stages.contracts.objects import Mounting
from stages.generation.collisions import resolve_collisions
from stages.generation.models import resize
from stages.generation.placed import Placed
from stages.generation.stacking import assign_supports
from stages.geometry.boxes import UprightBox

KINDS = ("chair", "table", "chair", "sofa", "chair", "chest_of_drawers", "stool", "bookshelf", "armchair", "plant_pot")
AREA = 1.0  # square metres of the room for a thing


def furnish(folders: AssetFolders, things: int, rng: np.random.Generator) -> list[Placed]:
    """Things of `KINDS` in turn, on the floor."""
    side, items = np.sqrt(AREA * things), []
    for number in range(things):
        models = [name for name in folders if name.rsplit("_", 1)[0] == KINDS[number % len(KINDS)]]
        folder = folders[str(rng.choice(models))]
        asset = read_json(Asset, folder / "asset.json")
        x, y = rng.uniform(0, side, 2)
        box = UprightBox([x, y, asset.size[2] / 2], asset.size, float(rng.integers(4)) * np.pi / 2)
        items.append(resize(Placed(f"thing_{number}", asset.category, asset, folder, box, Mounting(type=2))))
    return items


def measure_rooms(folders: AssetFolders, counts: list[int], rooms: int) -> Iterator[list[Any]]:
    """A row per number of things."""
    options = GenerationConfig()
    for things in counts:
        spent, left = np.zeros(2), 0
        for seed in range(rooms):
            items = furnish(folders, things, np.random.default_rng(seed))
            since = time.process_time()
            stacked = assign_supports(items, {}, {}, options, folders.categories)
            times = [time.process_time()]
            freed = resolve_collisions(stacked, [], options)
            times.append(time.process_time())
            spent += np.diff([since, *times])
            left += len(freed.left)
        yield [things, *(f"{each:.2f}" for each in spent / rooms), f"{spent.sum() / rooms:.2f}", left]


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--library", type=Path, default=Path("results/assets/library/library.json"))
    parser.add_argument("--things", type=int, nargs="+", default=[11, 22])
    parser.add_argument("--rooms", type=int, default=4)
    asked = parser.parse_args()
    heading = ["things", "stacked (CPU s)", "pushed apart", "together", "pairs left"]
    table(heading, measure_rooms(AssetFolders(asked.library), asked.things, asked.rooms))


if __name__ == "__main__":
    main()
