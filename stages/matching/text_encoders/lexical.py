"""Text encoder `lexical`: labels and categories compared by words, kinds of things and letters.

Words that no list here has are taken for those that WordNet says they are kinds of (benchmarks/wordnet.py).
"""

import re
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sklearn.feature_extraction.text import TfidfVectorizer

from roomkin.stages.config.matching import CandidateOptions
from roomkin.stages.contracts.categories import known_categories

# Words for the same thing that are no category of the library, or head several: each counts as the first of its line.
# Single words, singular. Those of one category are in its row (stages/contracts/categories).
SYNONYMS = """
cabinet cupboard sideboard hutch vanity
drawer dresser commode bureau tallboy
lamp light lantern sconce
plant houseplant flower flowerpot planter cactus fern bonsai
oven stove cooker range hob cooktop
sofa sectional divan
bed cot daybed futon
stool barstool
book magazine
box trunk
jug pitcher
"""
# Other words of the kinds of things: a label of no category finds its kin, not the first of the alphabet.
KINDS = {
    "storage": "cabinet chest drawer locker console",
    "appliance": "dryer machine printer",
    "seat": "seat",
    "dish": "dish pot jug",
    "flat": "board whiteboard blackboard tablet",
    "lamp": "lamp chandelier",
    "box": "radio stereo speaker",
    "plant": "plant pot tree",
    "bed": "crib mattress",
    "cloth": "cloth towel blanket",
    "device": "device charger",
    "fixture": "bathtub shower boiler",
}
CANONICAL = {
    word: first for first, *others in map(str.split, SYNONYMS.strip().splitlines()) for word in (first, *others)
}
GROUPS = {kind: set(text.split()) for kind, text in KINDS.items()}
for row in known_categories().values():
    if "_" not in row.name or row.like:  # else its last word heads it: "table" of coffee_table
        head = CANONICAL.setdefault(row.name.replace("_", ""), row.name.replace("_", ""))
        for word in [*row.names, *row.like]:
            CANONICAL.setdefault(word.replace(" ", ""), head)
        for kind in row.kin:
            GROUPS.setdefault(kind, set()).add(head)
MEANINGS_FILE = Path(__file__).with_name("wordnet.txt")  # a word that is known, and words that are kinds of it
MEANINGS = {
    word: first
    for first, *others in map(str.split, MEANINGS_FILE.read_text(encoding="utf-8").splitlines())
    for word in others
    if first != "#"
}
MIN_SIMILARITY = 0.03  # similarity below this is a few letters by chance; chosen
KNOWN = set(CANONICAL).union(*GROUPS.values())
LIKE_SPELLING = 0.85  # likeness of spelling from which on a word may be a known one with a letter wrong; chosen
FILLERS = {"set", "top", "unit", "piece", "furniture"}  # after the word that says what a thing is
ASIDE = re.compile(r"[,(]| (?:with|on|in|under|and) ")  # what follows says more of a thing, not what it is
SHARES = {"word": 0.6, "kind": 0.25, "letters": 0.15}  # letters tell among what has a word or kind in common


def split_words(label: str) -> list[str]:
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


# Further names of several words: "upper cabinet" is a wall cabinet. A single word may be short for several categories.
NAMES = {
    "".join(split_words(name)): row.name for row in known_categories().values() for name in row.names if " " in name
}


def _texts(tokens: list[str]) -> dict[str, str]:
    """What is compared, by aspect. The last word says what a thing is ("coffee table"): it counts twice."""
    canonical = [CANONICAL.get(word, word) for word in tokens + tokens[-1:]]
    own = [word for word in tokens if word not in canonical]
    kinds = [kind for word in canonical for kind, group in GROUPS.items() if word in group]
    return {"word": " ".join(canonical + own), "kind": " ".join(kinds), "letters": " ".join(tokens)}


class Understood(NamedTuple):
    """The words of a label, the last one says what it is; none if that is not known. And what is to be doubted."""

    words: list[str]
    doubt: str


def understand(label: str, categories: Sequence[str]) -> Understood:
    """What is understood of a label, given the names of categories."""
    named = [word for name in categories for word in split_words(name)]
    known = KNOWN.union(named)
    tokens = split_words(ASIDE.split(label)[0])
    for start in range(len(tokens)):
        if (name := NAMES.get("".join(tokens[start:]), "")) in categories:
            return Understood([*tokens[:start], *split_words(name)], "")
    if (pair := "".join(tokens[-2:])) in MEANINGS.keys() - known:  # "dutch oven"
        tokens[-2:] = [pair]
    while len(tokens) > 1 and tokens[-1] in FILLERS - known:
        tokens.pop()
    if not tokens:
        return Understood([], f"the label '{label}' is no word: taken by picture and size alone")
    said = tokens[-1]
    tokens = [part for word in tokens for part in ([word] if word in known else split_words(MEANINGS.get(word, word)))]
    last = tokens[-1]
    if last in known:
        shared = {CANONICAL.get(word, word) for word in named}.union(map("".join, map(split_words, categories)))
        if CANONICAL.get(last, last) in shared:
            return Understood(tokens, "")
        return Understood([last], f"no category of the library is called '{said}': taken by its kind, picture and size")
    if near := get_close_matches(last, sorted(known), n=1, cutoff=LIKE_SPELLING):
        return Understood([*tokens[:-1], near[0]], f"the word '{last}' is not known: taken for '{near[0]}'")
    return Understood([], f"the word '{last}' is not known: taken by picture and size alone")


def lexical_distance(label: str, categories: Sequence[str]) -> NDArray[np.float64]:
    """1 - similarity (C,), in [0, 1), of the label to each category; inf: they have nothing in common.

    Letters alone are nothing in common: a keyboard is no sideboard.
    """
    texts = [_texts(tokens) for tokens in (understand(label, categories).words, *map(split_words, categories))]
    shares = {aspect: _similarity([text[aspect] for text in texts], aspect == "letters") for aspect in SHARES}
    similarity = np.sum([share * shares[aspect] for aspect, share in SHARES.items()], axis=0)
    meant = (shares["word"] + shares["kind"]).any()
    return np.where(meant & (similarity > MIN_SIMILARITY), np.maximum(1 - similarity, 0.0), np.inf)


def _similarity(corpus: list[str], letters: bool) -> NDArray[np.float64]:
    """Cosine (C,) of the first of the texts with each of the others."""
    if not corpus[0] or not any(corpus[1:]):
        return np.zeros(len(corpus) - 1)
    how: dict[str, Any] = {"analyzer": "char_wb", "ngram_range": (3, 4)} if letters else {"token_pattern": r"\S+"}
    vectors = TfidfVectorizer(**how).fit_transform(corpus)
    return np.asarray((vectors[1:] @ vectors[0].T).toarray()[:, 0])


class TextEncoder:
    """Words, kinds and letters; needs no weights."""

    def __init__(self, options: CandidateOptions) -> None:
        pass

    def distance(self, label: str, categories: Sequence[str]) -> NDArray[np.float64]:
        """See `lexical_distance`."""
        return lexical_distance(label, categories)

    def doubt(self, label: str, categories: Sequence[str]) -> str:
        """What is not understood of a label; empty: nothing."""
        return understand(label, categories).doubt
