"""A key in any usual encoding is found."""

import base64
import codecs
from urllib.parse import quote

import pytest

from roomkin.plugins.vlm.endpoint import holds_key

KEY = "sk-OPSsecret-4f9b2c7d1e"


@pytest.mark.parametrize(
    "text",
    [
        "sk-OPSsecret\\u002d4f9b2c7d1e",
        "".join(f"\\u{ord(one):04x}" for one in KEY),
        "sk-OPS\u200bsecret-4f9b\u200b2c7d1e",
        "sk-OPS secret - 4f9b 2c7d1e",
        "".join(f"%{ord(one):02x}" for one in KEY),
        quote(quote("".join(f"&#{ord(one)};" for one in KEY))),
        KEY[::-1],
        KEY.upper(),
        KEY.encode().hex(),
        *(base64.b64encode(b"xyz"[:n] + KEY.encode() + b"tail").decode() for n in range(3)),
        base64.b32encode(KEY.encode()).decode(),
        codecs.encode(KEY, "rot13"),
    ],
)
def test_a_key_in_an_encoding_is_found(text: str) -> None:
    assert holds_key(f'{{"reason": "{text}", "choice": "1"}}', KEY)


def test_other_texts_hold_no_key() -> None:
    assert not holds_key('{"reason": "the wooden cabinet with two doors", "choice": "1"}', KEY)
    assert not holds_key("local", "local")
