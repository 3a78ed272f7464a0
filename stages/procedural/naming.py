"""The category that a name means: a label of a person, the name of a file or folder."""

import re

from stages.procedural.catalogue import CATEGORIES

NAMES = {
    name.replace(" ", "").replace("_", ""): record.name
    for record in CATEGORIES.values()
    for name in (record.name, *record.names.split(","))
    if name
}
# Words after that of a category that make another thing of it, or a part: `table_leg`, `bowl_drainer`.
PARTS = {
    "caddy", "door", "drainer", "handle", "holder", "knob", "leg", "lid", "panel", "rack", "seat", "shelf", "stand",
    "window",
}  # fmt: skip


def words(name: str) -> list[str]:
    """The words of a name, lower case, without numbers: `studyTable_2` has two."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)]


def category_in(name: str) -> str | None:
    """The category of ours that a name means, by its last words: `025_mug`, `studyTable`; None: none."""
    all_words = words(name)
    for end in range(len(all_words), 0, -1):
        if end < len(all_words) and all_words[-1] in PARTS and "with" not in all_words:
            return None
        for start in range(end):
            joined = "".join(all_words[start:end])
            if known := NAMES.get(joined) or NAMES.get(joined.removesuffix("s")):
                return known
    return None
