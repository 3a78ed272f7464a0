"""`python -m benchmarks.wordnet FOLDER`: write text_encoders/wordnet.txt, which explains words by those we know.

`wok`: a pan. A word counts by its first sense that is an artefact, else a publication or picture. `FOLDER` has
data.noun and index.noun of WordNet 3.0 (Debian: wordnet-base).
"""

import hashlib
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from roomkin.stages.matching.text_encoders.lexical import KNOWN, MEANINGS_FILE, split_words

# Categories and words of lexical.py, each with words of WordNet for it; `bowl#3`: its third sense, not its first as an
# artefact.
LINES = Path(__file__).with_name("wordnet_heads.txt").read_text(encoding="utf-8").splitlines()
HEADS = {head: words for head, *words in map(str.split, LINES)}
KINDS = ("dish",)  # of these a kind of things
FILES = (6, 10)  # noun.artifact, noun.communication
MIN_LETTERS = 3  # letters of a word


class Sense(NamedTuple):
    """A synset: the number of its file, and the synsets above it."""

    file: int
    above: list[str]


def read_senses(folder: Path) -> tuple[dict[str, Sense], dict[str, list[str]]]:
    """The synsets by their offset, and the offsets of each noun's senses, the most frequent first."""
    senses: dict[str, Sense] = {}
    for line in _lines(folder / "data.noun"):
        offset, file, _, words, *rest = line.partition("|")[0].split()
        pointers = rest[2 * int(words, 16) + 1 :]
        above = [pointers[at + 1] for at in range(0, len(pointers), 4) if pointers[at] == "@"]
        senses[offset] = Sense(int(file), above)
    nouns = {}
    for line in _lines(folder / "index.noun"):
        word, _, count, *rest = line.split()
        nouns[word] = rest[-int(count) :]
    return senses, nouns


def _lines(file: Path) -> list[str]:
    return [line for line in file.read_text(encoding="ascii").splitlines() if not line.startswith("  ")]


def explain(
    senses: Mapping[str, Sense], nouns: Mapping[str, list[str]], ours: Mapping[str, list[str]]
) -> dict[str, list[str]]:
    """The words that are explained, one or two joined, by the word of `ours` that explains them."""

    def senses_of(word: str) -> list[str]:
        """Those as an artefact, else as a publication or picture, or the one whose number is given."""
        word, _, number = word.partition("#")
        own = nouns.get(word, [])
        if number:
            return [own[int(number) - 1]]
        return next(filter(None, ([one for one in own if senses[one].file == file] for file in FILES)), [])

    heads = {senses_of(word)[0]: head for head, words in ours.items() for word in words}

    def head_of(sense: str) -> str | None:
        """The nearest head above a sense."""
        level = [sense]
        while level:
            if found := [heads[one] for one in level if one in heads]:
                return found[0]
            level = [above for one in level for above in senses[one].above]
        return None

    explained: dict[str, list[str]] = {}
    for word in nouns:
        tokens = split_words(word)
        found = [head_of(sense) for sense in senses_of(word)]
        if not found or found[0] is None or len(tokens) not in (1, 2) or not "".join(tokens).isalpha():
            continue
        if "".join(tokens) in KNOWN or min(map(len, tokens)) < MIN_LETTERS:
            continue
        *_, last = tokens
        says = {head_of(sense) for sense in senses_of(last)[:1]}
        if len(tokens) == 2 and (says & set(found) or (last in KNOWN and found[0] in KINDS)):
            continue  # the last word says it
        explained.setdefault(found[0], []).append("".join(tokens))
    return {head: sorted(set(words)) for head, words in sorted(explained.items())}


def run(folder: Path, out: Path = MEANINGS_FILE) -> None:
    """Write the table: a head and its words in a line."""
    lines = [f"{head} {' '.join(words)}" for head, words in explain(*read_senses(folder), HEADS).items()]
    digest = hashlib.sha256((folder / "data.noun").read_bytes()).hexdigest()
    notice = [f"From data.noun of WordNet 3.0 (sha256 {digest}) by benchmarks/wordnet.py.", "", ""]
    numbered = (folder / "data.noun").read_text(encoding="ascii").splitlines()
    notice += [re.sub(r"^ +[0-9]+ ?", "", line) for line in numbered if line.startswith("  ")]  # its license
    head = "".join(f"# {line}".rstrip() + "\n" for line in notice)
    out.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    run(Path(sys.argv[1]))
