"""Text encoder `lexical`: labels and categories compared by words, kinds of things and letters."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from sklearn.feature_extraction.text import TfidfVectorizer

from stages.config.matching import MatchingConfig

# Words for the same thing: each also counts as the first of its line. Single words, singular.
SYNONYMS = """
cabinet cupboard sideboard credenza
wardrobe closet armoire
dresser commode bureau
refrigerator fridge freezer icebox
television tv telly monitor screen
sofa couch settee loveseat
shelf bookshelf bookcase rack shelving
wallshelf wallrack shelfboard
stool footstool ottoman
lamp light lantern
picture painting poster artwork canvas frame photo
plant houseplant flower flowerpot planter
mug cup beaker
bottle flask
box carton crate package
rug carpet mat
stove cooker
book novel
nightstand bedsidetable bedsidecabinet nighttable
tvstand tvcabinet tvunit tvconsole mediaconsole mediaunit
trashcan bin trashbin trash garbage rubbish wastebasket dustbin garbagecan
armchair easychair recliner
kettle teapot teakettle
pan skillet frypan saucepan
jar canister can tin tincan
candlestick candle candleholder candlestand
laptop computer
jug pitcher carafe
"""
# Kinds of things: a label without a category of its own name finds its kin, not the first of the alphabet.
KINDS = """
cabinet wardrobe dresser chest nightstand tvstand drawer locker shelf wallshelf
refrigerator oven stove microwave dishwasher washer dryer toaster
chair stool armchair bench sofa seat
table desk counter workbench
bowl mug plate dish pot pan kettle vase bottle jar glass jug
television picture mirror clock laptop board
lamp candlestick chandelier
book box basket trashcan bag
plant pot vase tree
bed sofa crib mattress
"""
CANONICAL = {
    word: first for first, *others in map(str.split, SYNONYMS.strip().splitlines()) for word in (first, *others)
}
GROUPS = [set(line.split()) for line in KINDS.strip().splitlines()]
LEAST = 0.03  # similarity below this is a few letters by chance
KNOWN = set(CANONICAL).union(*GROUPS)
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
    kinds = [f"kind{number}" for word in canonical for number, group in enumerate(GROUPS) if word in group]
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
