"""Whether a text holds a key in an encoding: a ledger that is shared must not."""

import base64
import codecs
import html
import re
from urllib.parse import unquote

ROUNDS = 3  # encodings within each other that are undone
SHORTEST = 8  # letters and digits of a key that is looked for: shorter ones are words


def holds_key(text: str, key: str) -> bool:
    """Whether a text has a key as escapes of JSON, of addresses or of HTML, cut by other characters, turned round, in
    base64 or 32, as hexadecimal numbers, or in ROT13; small and capital letters alike."""
    if len(_letters(key)) < SHORTEST:
        return False
    wanted = {_letters(form) for form in _encode(key)}
    for _ in range(ROUNDS):
        found = _letters(text)
        if any(form in found for form in wanted):
            return True
        text = _decode(text)
    return False


def _encode(key: str) -> list[str]:
    data = key.encode()
    forms = [key, key[::-1], codecs.encode(key, "rot13"), data.hex()]
    for before in range(3):  # where it begins within three bytes decides on its letters
        coded = base64.b64encode(b"\0" * before + data).decode().rstrip("=")
        forms.append(coded[(8 * before + 5) // 6 : len(coded) - 1].translate(str.maketrans("", "", "+/")))
    return [*forms, base64.b32encode(data).decode().rstrip("=")[:-1]]


def _decode(text: str) -> str:
    text = re.sub(r"\\u\{?([0-9a-fA-F]{4})\}?|\\x([0-9a-fA-F]{2})", lambda m: chr(int(m[1] or m[2], 16)), text)
    return html.unescape(unquote(text))


def _letters(text: str) -> str:
    """Letters and digits alone: what cuts a key, seen or not, falls out."""
    return re.sub("[^a-z0-9]", "", text.lower())
