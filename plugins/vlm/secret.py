"""Take a key out of what a server says, however it is written there."""

import html
import re
import unicodedata
from base64 import urlsafe_b64decode
from collections.abc import Iterator
from urllib.parse import unquote

HIDDEN = "***"
SECRET = 8  # letters and digits at least: shorter ones, as local servers take, are words that answers use
DEPTH = 2  # encodings within one another
ESCAPE = re.compile(r"\\u\{?([0-9a-f]{2,6})\}?|\\x([0-9a-f]{2})|\\[bfnrtv]", re.IGNORECASE)


def hide_key(text: str, key: str) -> str:
    """A text without a key; nothing of the text if the key is in it in other case, backwards, spaced, or encoded."""
    if not key:
        return text
    text, sought = text.replace(key, HIDDEN), _squeeze_text(key)
    if len(sought) < SECRET:
        return text
    forms = {text, text[::-1]}
    for left in range(DEPTH, -1, -1):
        if any(way in _squeeze_text(form) for form in forms for way in (sought, sought[::-1])):
            return HIDDEN
        forms = {decoded for form in forms for decoded in _decode_text(form)} if left else forms
    return text


def _squeeze_text(text: str) -> str:
    """Its letters and digits, small."""
    return "".join(filter(str.isalnum, unicodedata.normalize("NFKC", text))).casefold()


def _decode_text(text: str) -> Iterator[str]:
    """What a text may stand for: with its escapes, or parts of it as base64 or hexadecimal digits."""
    yield html.unescape(unquote(ESCAPE.sub(_character, text)))
    run = re.sub(r"[^\w+/-]", "", text, flags=re.ASCII).replace("+", "-").replace("/", "_")
    for start in range(4):  # wherever in the text it begins
        part = run[start : len(run) - ((len(run) - start) % 4 == 1)]
        yield urlsafe_b64decode(part + "=" * (-len(part) % 4)).decode("utf-8", "ignore")
    digits = "".join(re.findall(r"[0-9a-f]", _squeeze_text(text)))
    for start in range(2):
        yield bytes.fromhex(digits[start : len(digits) - (len(digits) - start) % 2]).decode("utf-8", "ignore")


def _character(found: re.Match[str]) -> str:
    code = int(found[1] or found[2] or "20", 16)
    return chr(code) if code < 0x110000 else ""
