"""The category that docs/assets.md adds: one module, and it is sampled, built, known to rooms and found by its name."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
USE = """
import sys
from pathlib import Path

from roomkin.plugins.furniture import categories

categories.__path__.append(sys.argv[1])

from roomkin.stages.config import categories as counts
from roomkin.stages.contracts import categories as rows
from roomkin.plugins.furniture import catalogue, facts, folder

counts.FILE, rows.FILE = Path(sys.argv[1]) / "counts.json", Path(sys.argv[1]) / "categories.json"
facts.run()  # what `make config` writes, for config and rooms, and for all that know categories by name
assert '"plinth": [5, false, false]' in counts.FILE.read_text()
from roomkin.stages.matching.text_encoders.lexical import lexical_distance

asset = folder.build(catalogue.sample("plinth", 4, seed=0), None, Path(sys.argv[1]) / "made", "plinth_04", "plinth")
assert (asset.category, asset.symmetry, asset.placement) == ("plinth", "quarter_turn", "floor")
assert 0.7 <= asset.size[2] <= 1.1
assert rows.category_in("oldPedestal_2") == "plinth"  # a model of yours
assert lexical_distance("plinth", ["table", "plinth"]).argmin() == 1
assert lexical_distance("pedestal", ["table", "plinth"]).argmin() == 1
"""


def test_a_category_is_one_module(tmp_path: Path) -> None:
    page = (ROOT / "docs/assets.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```python\n# plugins/furniture/categories/plinths.py\n(.*?)```", page, re.DOTALL)
    (tmp_path / "plinths.py").write_text(text, encoding="utf-8")
    subprocess.run([sys.executable, "-c", USE, str(tmp_path)], check=True, cwd=ROOT, timeout=120)
