"""A server that says the key back, in many ways and places: no file, line or error has it in any of them."""

import json
from base64 import b64encode
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path

import pytest

from plugins.vlm.ask import NoAnswerError
from plugins.vlm.secret import HIDDEN, hide_key
from plugins.vlm.tests.chat_server import KEY, Handler, Step, chooses, fails, reply, says, sends, serving
from plugins.vlm.tests.test_vlm import PROMPT, ask, asker
from stages.contracts import InputError

WAYS: dict[str, Callable[[str], str]] = {
    "as it is": str,
    "large": str.upper,
    "backwards": lambda key: key[::-1],
    "spaced": " ".join,
    "in lines": "\n".join,
    "escaped": lambda key: "".join(f"\\u{ord(letter):04x}" for letter in key),
    "percent": lambda key: "".join(f"%{ord(letter):02X}" for letter in key),
    "percent twice": lambda key: "".join(f"%25{ord(letter):02X}" for letter in key),
    "entities": lambda key: "".join(f"&#{ord(letter)};" for letter in key),
    "base64": lambda key: b64encode(key.encode()).decode(),
    "inside base64": lambda key: b64encode(f"Bearer {key}.".encode()).decode(),
    "base64 backwards": lambda key: b64encode(key.encode()).decode()[::-1],
    "hexadecimal": lambda key: key.encode().hex(" "),
}


def answers(**said: str) -> Step:
    return says(json.dumps({"reason": "it looks like it", "choice": "1", **said}))


def breaks_off(line: str) -> Step:
    """A line that is no status."""

    def step(handler: Handler, body: object) -> None:
        handler.wfile.write(f"{line}\r\n\r\n".encode())
        handler.close_connection = True

    return step


def bodies(status: HTTPStatus, text: str) -> Step:
    return lambda handler, body: handler.send(status, text.encode())


def places(told: str) -> dict[str, Step]:
    """Where a server may say it."""
    line = " ".join(told.split("\n"))
    return {
        "a reason": answers(reason=f"your key is {told}, keep it"),
        "a field": answers(**{told: "1"}),
        "a field, escaped": says('{"reason": "", "choice": "1", "' + told.replace("\n", "\\n") + '": 1}'),
        "a choice": answers(choice=told),
        "no JSON": says(f"What is {told}?"),
        "the model": sends(json.dumps(reply('{"reason": "", "choice": "1"}') | {"model": told}).encode()),
        "a refusal": fails(400, f"no such option: {told}"),
        "an error": fails(500, f"bad: {told}"),
        "an error without JSON": bodies(HTTPStatus.BAD_GATEWAY, f"<p>{told}</p>"),
        "no such page": fails(404, told),
        "a redirect": fails(307, told, Location=f"http://127.0.0.1:9/{line}"),
        "a header": sends(b"{}", Content_Length=line),
        "a pause": fails(429, told, Retry_After=line),
        "the status line": breaks_off(f"HTTP/1.1 {line} {line}"),
        "no status line": breaks_off(line),
    }


@pytest.mark.parametrize("way", WAYS)
def test_the_key_is_written_nowhere(
    tmp_path: Path, way: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TOY_KEY", KEY)
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    told = WAYS[way](KEY)
    for place, step in places(told).items():
        said = ""
        with serving(step, key=KEY) as server:
            try:
                one = asker(tmp_path / place, server.url, key_env="TOY_KEY")
                said = ask(one, PROMPT._replace(system=place)) + one.summary()
            except (NoAnswerError, InputError) as error:
                said = f"{error} {error.__context__}"
                assert "\n" not in str(error), place
        said += "".join(path.read_text() for path in tmp_path.rglob("*") if path.is_file())
        said += "".join(capfd.readouterr())
        said = said.replace(server.url, "")
        found = [name for name, write in WAYS.items() if write(KEY) in said or json.dumps(write(KEY))[1:-1] in said]
        assert not found, (place, found)
        assert hide_key(said, KEY) == said, place


def test_what_only_looks_like_a_key_stays() -> None:
    said = "The test of 7 drawers: sk, 3 of 9 are alike; see c2stdGVz and 736b."
    assert hide_key(said, KEY) == said
    assert hide_key("none of them", "none") == f"{HIDDEN} of them"
    assert hide_key("a noné", "") == "a noné"


def test_a_server_that_puts_off_for_days_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    for pause in ("1e300", "inf", "90000"):
        pauses: list[float] = []
        busy, late = serving(fails(429, "later", Retry_After=pause), chooses("1")), "HTTP 429: later; not before"
        with busy as server, pytest.raises(NoAnswerError, match=late):
            ask(asker(tmp_path / pause, server.url, pauses))
        assert not pauses


def test_what_a_server_says_steers_no_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    evil = "\x1b]0;pwned\x07\x1b[2J\u202e"
    for place in ("a field", "an error", "an error without JSON", "a refusal", "no status line"):
        with serving(places(evil)[place]) as server, pytest.raises((NoAnswerError, InputError)) as caught:
            ask(asker(tmp_path / place, server.url))
        assert str(caught.value).isprintable() and "pwned" in str(caught.value), place
