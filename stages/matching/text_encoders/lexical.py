"""Text encoder `lexical`: labels and categories compared by words, kinds of things and letters."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.feature_extraction.text import TfidfVectorizer

from stages.config.matching import MatchingConfig
from stages.procedural.catalogue import CATEGORIES

# Words for the same thing that are no category of the library, or head several: each counts as the first of its line.
# Single words, singular. Those of one category are in its record (stages/procedural/categories).
SYNONYMS = """
cabinet cupboard sideboard credenza
dresser commode bureau
lamp light lantern
plant houseplant flower flowerpot planter
rug carpet mat
stove cooker
jug pitcher carafe
"""
# Other words of the kinds of things: a label of no category finds its kin, not the first of the alphabet.
KINDS = {
    "storage": "cabinet dresser chest drawer locker",
    "appliance": "stove washer dryer",
    "seat": "seat",
    "table": "counter workbench",
    "dish": "dish pot glass jug",
    "flat": "board",
    "lamp": "lamp chandelier",
    "box": "bag",
    "plant": "plant pot tree",
    "bed": "crib mattress",
}
CANONICAL = {
    word: first for first, *others in map(str.split, SYNONYMS.strip().splitlines()) for word in (first, *others)
}
GROUPS = {kind: set(text.split()) for kind, text in KINDS.items()}
for record in CATEGORIES.values():
    if "_" not in record.name or record.like:  # else its last word heads it: "table" of coffee_table
        head = CANONICAL.setdefault(record.name.replace("_", ""), record.name.replace("_", ""))
        for word in record.words:
            CANONICAL.setdefault(word, head)
        for kind in record.kin.split(", "):
            GROUPS.setdefault(kind, set()).add(head)
LEAST = 0.03  # similarity below this is a few letters by chance
KNOWN = set(CANONICAL).union(*GROUPS.values())
SHARES = {"word": 0.6, "kind": 0.25, "letters": 0.15}  # of the similarity; letters: plurals, compounds, spelling


def words(label: str) -> list[str]:
    """A label or category as lower-case words: underscores removed, plural endings cut."""
    parts = ["".join(filter(str.isalnum, part)) for part in label.lower().replace("_", " ").replace("-", " ").split()]
    if "".join(parts) in KNOWN:  # "night stand" as nightstand
        parts = ["".join(parts)]
    result = []
    for word in parts:
        if len(word) > 3 and word.endswith("s") and not word.endswith(("ss", "us")):
            word = word[:-2] if word.endswith(("shes", "ches", "xes", "sses")) else word[:-1]
        word = {"shelve": "shelf"}.get(word, word)
        if word:
            result.append(word)
    return result


def _texts(tokens: list[str]) -> dict[str, str]:
    """What is compared, by aspect. The last word says what a thing is ("coffee table"): it counts twice."""
    canonical = [CANONICAL.get(word, word) for word in tokens + tokens[-1:]]
    own = [word for word in tokens if word not in canonical]
    kinds = [kind for word in canonical for kind, group in GROUPS.items() if word in group]
    return {"word": " ".join(canonical + own), "kind": " ".join(kinds), "letters": " ".join(tokens)}


def lexical_distance(label: str, categories: Sequence[str]) -> NDArray[np.float64]:
    """1 - similarity (C,), in [0, 1), of the label to each category; inf: they have nothing in common."""
    texts = [_texts(words(text)) for text in [label, *categories]]
    similarity = np.zeros(len(categories))
    for aspect, share in SHARES.items():
        corpus = [text[aspect] for text in texts]
        if not corpus[0] or not any(corpus[1:]):
            continue
        if aspect == "letters":
            vectorizer = TfidfVectorizer(analyzer="char_wb", ngram_range=(3, 4))
        else:
            vectorizer = TfidfVectorizer(token_pattern=r"\S+")
        vectors = vectorizer.fit_transform(corpus)
        similarity += share * (vectors[1:] @ vectors[0].T).toarray()[:, 0]
    return np.where(similarity > LEAST, np.maximum(1 - similarity, 0.0), np.inf)


class TextEncoder:
    """Words, kinds and letters; needs no weights."""

    def __init__(self, options: MatchingConfig) -> None:
        pass

    def distance(self, label: str, categories: Sequence[str]) -> NDArray[np.float64]:
        """See `lexical_distance`."""
        return lexical_distance(label, categories)
