"""Counts and sizes in words for people; letters of theirs."""

import re
import unicodedata
from collections.abc import Iterable


def count(number: int, noun: str, plural: str = "") -> str:
    """'1 run', '2 runs'; `plural`: where it is not the noun with an s."""
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def describe_size(size: Iterable[float]) -> str:
    """Depth, width and height, metres, as people say them: '80 wide × 60 deep × 90 cm high'."""
    depth, width, height = (f"{100 * extent:.0f}" for extent in size)
    return f"{width} wide × {depth} deep × {height} cm high"


def plain_letters(text: str) -> str:
    """In small letters, without accents, in one Unicode form; `Łóżka` is lozka."""
    letters = unicodedata.normalize("NFKD", unicodedata.normalize("NFKC", text).casefold())
    bare = (_plain_letter(one) for one in letters if not 0x300 <= ord(one) < 0x370)
    return unicodedata.normalize("NFC", "".join(bare))


def list_plain_words(text: str) -> list[str]:
    """The words of any script in plain letters, without what is no letter: `Bürostuhl_2` is burostuhl."""
    letters = plain_letters(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text))
    return "".join(one if unicodedata.category(one)[0] in "LM" else " " for one in letters).split()


def _plain_letter(letter: str) -> str:
    """What a Latin letter without an accent looks like: l of ł, ae of æ."""
    name = unicodedata.name(letter, "")
    if letter.isascii() or not name.startswith("LATIN SMALL LETTER"):
        return letter
    return name.split(" WITH ")[0].split()[-1].lower()
