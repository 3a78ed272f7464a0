"""The samples of docs/contracts.md, a small file of every kind: `python -m tests.unit.contract_samples` writes them.

The files are those that the tests of contracts break one by one (contract_files.py): the docs show what checks take.
"""

import json
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from safetensors import safe_open

from stages.contracts.kinds import KINDS
from tests.unit.contract_files import FILES, write_files

DOCS = Path(__file__).resolve().parents[2] / "docs/contracts.md"
HEADING = "## A sample of each\n"
WIDTH = 118
ARRAYS = (".npz", ".npy", ".h5", ".safetensors")


def folded(value: Any, indent: int = 0) -> str:
    """JSON in which whatever fits into a line stands in one."""
    line = json.dumps(value, ensure_ascii=False)
    if len(line) + indent <= WIDTH - 2 or not isinstance(value, dict | list) or not value:
        return line
    space = " " * (indent + 2)
    if isinstance(value, dict):
        parts = [f"{json.dumps(name)}: {folded(item, indent + 2)}" for name, item in value.items()]
        opening, closing = "{}"
    else:
        parts = [folded(item, indent + 2) for item in value]
        opening, closing = "[]"
    return f"{opening}\n{space}" + f",\n{space}".join(parts) + f"\n{' ' * indent}{closing}"


def arrays(path: Path) -> list[str]:
    """Name, shape and type of every array of a file."""
    if path.suffix == ".h5":
        lines: list[str] = []
        with h5py.File(path) as file:
            for name, value in file.get("data", {}).attrs.items() if "data" in file else ():
                lines.append(f"data.attrs[{name!r}] = {str(value)[:60]}{' ...' if len(str(value)) > 60 else ''}")
            file.visititems(lambda name, item: lines.append(_array(name, item)) if hasattr(item, "shape") else None)
        return lines
    if path.suffix == ".safetensors":
        with safe_open(path, framework="np") as weights:
            return [_array(name, weights.get_tensor(name)) for name in weights.keys()]  # noqa: SIM118 - no mapping
    found = np.load(path)
    return [_array(name, found[name]) for name in found.files] if path.suffix == ".npz" else [_array("", found)]


def _array(name: str, array: Any) -> str:
    return f"{name} {tuple(array.shape)} {array.dtype}".strip()


def sample(kind: str, path: Path) -> str:
    """A file of a kind as Markdown, with the arrays beside it."""
    text = path.read_text() if path.suffix not in ARRAYS else "\n".join(arrays(path))
    language = {".json": "json", ".csv": "csv", ".jsonl": "json"}.get(path.suffix, "text")
    if path.suffix == ".json":
        text = folded(json.loads(text))
    beside = [file for file in KINDS[kind].files(path) if file != path]
    lines = [f"`{file.name}`: {'; '.join(arrays(file))}." for file in beside if file.suffix in ARRAYS]
    lines += [f"`{file.name}`: a picture." for file in beside if file.suffix == ".png"]
    more = "".join(f"\n{line}\n" for line in lines)
    return f"### {kind}\n\n`{path.name}`\n\n```{language}\n{text.strip()}\n```\n{more}"


def section(root: Path) -> str:
    """The section of the docs; `root`: an empty folder for the files."""
    write_files(root)
    intro = (
        "Small files that the checks take, `python -m stages.contracts KIND FILE`; a command of yours that writes such "
        "files\nneeds no look at our source. Optional fields are left out where they have their defaults.\n"
    )
    return "\n".join([HEADING, intro, *(sample(kind, root / name) for kind, name in FILES.items())])


def main() -> None:
    """Write the section into the docs."""
    with tempfile.TemporaryDirectory() as folder:
        text = DOCS.read_text(encoding="utf-8").partition(HEADING)[0].rstrip("\n")
        DOCS.write_text(f"{text}\n\n{section(Path(folder))}", encoding="utf-8")


if __name__ == "__main__":
    main()
