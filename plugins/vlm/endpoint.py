"""Requests to a chat endpoint: failures sorted, no key in what is written down; a ledger: nothing is asked twice."""

import base64
import codecs
import fcntl
import html
import json
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple
from urllib.parse import unquote

from roomkin.plugins.vlm.package import VlmConfig
from roomkin.plugins.vlm.prompt import UnusableError
from roomkin.stages.contracts.errors import InputError, escape_control
from roomkin.stages.contracts.files import Contract, Document, read_json, write_json
from roomkin.stages.contracts.types import Count, NonNegative, Text

AGAIN = "delete the file, and it is asked again"
ROUNDS = 3  # encodings within each other that are undone
SHORTEST = 8  # letters and digits of a key that is looked for: shorter ones are words
RETRIES = 4  # after a busy server or no reply, at longer and longer pauses, or when the server says
BUSY = (408, 409, 429)
MAX_QUOTED = 300  # characters of a message or of a bad answer that are repeated
HIDDEN = "***"
ESCAPED = re.compile(r"\\u([0-9a-fA-F]{4})")  # a letter in JSON


class Exchange(Contract):
    """One request that was replied to, or a run of those that were not."""

    requests: Count  # sent, with those to a busy server
    text: str = ""  # of the answer, cut to a readable length
    problem: str = ""  # why it cannot be used; empty: it can
    served_by: str = ""  # the model that the server names
    tokens_in: Count = 0
    tokens_out: Count = 0
    estimated: bool = False  # our estimate of the tokens: the server counts none


class Entry(Document):
    """A question to one model, its answer, and the cost."""

    key: Text
    question: Text  # digest of `asked`, equal for all models
    model: Text
    settings: dict[str, Any]
    about: str = ""  # for people
    names: dict[str, str] = {}  # what the choices stand for
    asked: list[str]
    exchanges: list[Exchange]
    outcome: Literal["answered", "unusable", "unreached", "open"]  # open: it was stopped in the middle
    answer: dict[str, Any] | None = None
    cost: NonNegative

    @property
    def requests(self) -> int:
        """Requests sent."""
        return sum(exchange.requests for exchange in self.exchanges)

    @property
    def problem(self) -> str:
        """Why there is no answer."""
        return self.exchanges[-1].problem if self.exchanges else ""


class Spent(NamedTuple):
    """Requests and their cost."""

    requests: int
    cost: float


class Ledger:
    """A folder of entries, which several processes may write into."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._seen: dict[Path, tuple[tuple[int, int], Spent]] = {}

    def find(self, key: str) -> Entry | None:
        """The entry of a key.

        Raises:
            InputError: its file is damaged, or is about something else.
        """
        path = self.path(key)
        if not path.is_file():
            return None
        entry = read_json(Entry, path, AGAIN)
        if entry.key != key:
            raise InputError(path, "holds another call than its name says.", AGAIN, code="E-VLM-LEDGER")
        return entry

    @contextmanager
    def lock_key(self, key: str) -> Iterator[None]:
        """Held while a key is looked up and asked, so that no two jobs pay for the same call."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with (self.folder / ".lock").open("wb") as file:
            fcntl.lockf(file, fcntl.LOCK_EX, 1, int(key[:12], 16))  # one byte per key; freed with the file
            yield

    def write(self, entry: Entry) -> None:
        """Keep an entry, in the place of what was known of its key."""
        write_json(self.path(entry.key), entry)

    def path(self, key: str) -> Path:
        """File of a key."""
        return self.folder / f"{key}.json"

    def sum_costs(self) -> Spent:
        """Sums over the whole ledger; files that did not change are not read again."""
        paths = sorted(self.folder.glob("[0-9a-f]*.json"))
        for path in paths:
            stat = path.stat()
            stamp = (stat.st_mtime_ns, stat.st_size)
            if path not in self._seen or self._seen[path][0] != stamp:
                entry = read_json(Entry, path, AGAIN)
                self._seen[path] = (stamp, Spent(entry.requests, entry.cost))
        sums = [self._seen[path][1] for path in paths]
        return Spent(sum(one.requests for one in sums), sum(one.cost for one in sums))


if TYPE_CHECKING:
    import openai


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


class UnreachedError(Exception):
    """The server gave no reply, however often it was asked."""


class RefusedRequestError(Exception):
    """The server does not take this request (400, 413, 422 ...)."""


class Endpoint:
    """`url`/chat/completions, with the key of the environment. `allow`: called before every attempt; may raise."""

    def __init__(self, options: VlmConfig, allow: Callable[[], None]) -> None:
        self.options, self._allow = options, allow

    @property
    def key(self) -> str:
        """The key; empty: none is there, or none is asked for."""
        return os.environ.get(self.options.key_env, "").strip() if self.options.key_env else ""

    @cached_property
    def _client(self) -> "openai.OpenAI":
        try:
            import openai  # half a second, and nothing that replays needs it
        except ModuleNotFoundError:
            mend = "pip install openai, or vlm.mode: replay"
            raise InputError("vlm", "openai is not installed.", mend, code="E-LIBRARY-MISSING") from None
        hooks = {"request": [lambda _: self._allow()]}
        http = openai.DefaultHttpxClient(event_hooks=hooks, follow_redirects=False)  # no pictures for other hosts
        url, timeout = self.options.url, self.options.timeout
        return openai.OpenAI(
            api_key=lambda: self.key or "none", base_url=url, timeout=timeout, max_retries=RETRIES, http_client=http
        )

    def post(self, body: dict[str, Any]) -> dict[str, Any]:
        """The reply to a request.

        Raises:
            UnreachedError, RefusedError: see there.
            UnusableError: it is no JSON object.
            InputError: key, model or address are wrong, or the account is empty: no other request would do better.
        """
        self._check_key()
        client = self._client
        import openai

        first = {name: body[name] for name in ("model", "messages")}
        try:
            answer = client.chat.completions.with_raw_response.create(**first, extra_body=body)
            reply = json.loads(answer.content)
        except openai.APIStatusError as error:
            self._give_up(error.status_code, self.quote_server(_message(error)))
        except openai.APIConnectionError as error:
            raise UnreachedError(self.quote_server(f"{error} ({error.__cause__})")) from None
        except (ValueError, RecursionError):
            raise UnusableError("the reply is no JSON") from None
        if not isinstance(reply, dict):
            raise UnusableError("the reply is no JSON object")
        return reply

    def _check_key(self) -> None:
        """Refuse a key that is not set, or holds what cannot be sent."""
        where = f"environment variable {self.options.key_env}"
        if self.options.key_env and not self.key:
            mend = "export it; or vlm.key_env: '' for a server without keys, or vlm.mode: replay"
            raise InputError(where, "is not set, and the ledger lacks a call.", mend, code="E-VLM-KEY")
        if not (self.key.isascii() and self.key.isprintable()):
            fix = "set it to the key and nothing else"
            raise InputError(where, "holds characters that no key has.", fix, code="E-VLM-KEY")

    def _give_up(self, status: int, message: str) -> None:
        """Raise what waiting does not mend, or has not."""
        where, said = self.options.url, f"HTTP {status}: {message}".rstrip(": ")
        if status in (401, 403):
            key = f"the key in {self.options.key_env}" if self.options.key_env else "a key"
            fix = "set another, see vlm.key_env"
            raise InputError(where, f"refuses {key} (HTTP {status}).", fix, code="E-VLM-KEY") from None
        if status == 402 or "insufficient_quota" in message:
            fix = "pay, or use another"
            raise InputError(where, f"HTTP {status}: nothing is left.", fix, code="E-VLM-ACCOUNT") from None
        if status in (404, 405) or status < 400:
            raise InputError(where, said, "correct vlm.url or vlm.model", code="E-VLM-ADDRESS") from None
        raise (RefusedRequestError if status < 500 and status not in BUSY else UnreachedError)(said) from None

    def quote_server(self, text: str) -> str:
        """A server's answer in one line that may be shown."""
        return escape_control(self.hide_key(" ".join(text.split()))[:MAX_QUOTED])

    def hide_key(self, text: str) -> str:
        """Text without the key, should a server repeat it, and without halves of characters, which no file holds."""
        text = text.encode("utf-8", "replace").decode("utf-8")
        if not self.key:
            return text
        plain = ESCAPED.sub(lambda found: chr(int(found[1], 16)), text)
        hidden = (plain if self.key in plain else text).replace(self.key, HIDDEN)
        return HIDDEN if holds_key(hidden, self.key) else hidden


def _message(error: "openai.APIStatusError") -> str:
    """The server's message about an error."""
    body = error.body
    words = [body.get("code"), body.get("message")] if isinstance(body, dict) else [body or error.response.text]
    return " ".join(str(word) for word in words if word)
