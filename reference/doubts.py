"""The section of docs/errors.md on doubts: each as the code declares it (`stages.contracts.doubt`)."""

import re
from pathlib import Path

from stages.contracts.doubt import MEND, DoubtKind

HEAD = """\
## Doubts

What may be wrong with an object of a scene, and a person can mend, is doubted on its [page](corrections.md).
A limit that is a key of the [config](config.md) is yours.

| code | doubt | what is compared | limit | from | file |
|---|---|---|---|---|---|
"""


def section(root: Path) -> str:
    """The table of all doubts, gravest first, and what mends each cause."""
    texts = {
        path.relative_to(root).as_posix(): path.read_text(encoding="utf-8")
        for home in ("stages", "plugins")
        for path in (root / home).rglob("*.py")
        if "tests" not in path.relative_to(root).parts
    }
    rows = []
    for kind in sorted(DoubtKind, key=lambda one: list(MEND).index(one.cause)):
        text = re.sub(r":\.\d+f", "", kind.text)
        files = ", ".join(sorted(file for file, text in texts.items() if re.search(rf"\b{kind.name}\.of\(", text)))
        cells = (kind.code, f"{kind.cause}: {text}", kind.compared, _limit(kind), kind.source, files)
        rows.append(f"| {' | '.join(cells)} |")
    mends = [f"* {cause}: {mend}." for cause, mend in MEND.items()]
    return HEAD + "\n".join([*rows, "", "What helps, by the cause:", "", *mends]) + "\n"


def _limit(kind: DoubtKind) -> str:
    if isinstance(kind.limit, tuple):
        return f"{kind.limit[0]:g} to {kind.limit[1]:g} {kind.unit}"
    return f"`{kind.limit}`" if isinstance(kind.limit, str) and kind.limit else f"{kind.limit} {kind.unit}".strip()
