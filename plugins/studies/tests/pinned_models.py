"""Make the models that committed files of a study name, and print the id and checksum of each: SEED FILE [FILE ...]."""

import sys
import tempfile
from pathlib import Path

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.plugins.studies.pinned_file import read_pinned

seed, plans = int(sys.argv[1]), [read_pinned(Path(file)) for file in sys.argv[2:]]
items = {item.asset: item for plan in plans for item in (*plan.assets, *plan.test_assets)}
with tempfile.TemporaryDirectory() as folder:
    for name, item in sorted(items.items()):
        recipe = sample(item.category, int(name.rsplit("_", 1)[1]), seed)
        print(name, build(recipe, None, Path(folder) / name, name, item.category).checksum)
