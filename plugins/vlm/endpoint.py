"""One request to a chat endpoint, sent again while the server is busy; other failures are reported."""

import json
import os
import time
from collections.abc import Callable
from datetime import UTC, datetime
from email.message import Message
from email.utils import parsedate_to_datetime
from http import HTTPStatus
from http.client import HTTPException
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request

from plugins.vlm.answers import LONGEST
from plugins.vlm.config import VlmConfig
from plugins.vlm.deadline import MAX_REPLY, response_to
from plugins.vlm.secret import hide_key
from stages.contracts.errors import InputError, escape_control

BUSY = {HTTPStatus.REQUEST_TIMEOUT, HTTPStatus.CONFLICT, HTTPStatus.TOO_EARLY, HTTPStatus.TOO_MANY_REQUESTS}
PAUSES = (2, 4, 8, 16)  # seconds before each further attempt, if the server does not say
LONGEST_PAUSE = 60  # seconds, if it does
LATER = 3600  # seconds: a server that asks for more is not waited for
SHOWN = 300  # characters of a message or of a bad answer that are repeated


class UnreachedError(Exception):
    """The server gave no reply, however often it was asked."""


class RefusedError(Exception):
    """The server does not take this request (400, 413, 422 ...)."""

    def __init__(self, status: int, message: str) -> None:
        self.status, self.message = status, message
        super().__init__(f"HTTP {status}: {message}")


class OversizedError(Exception):
    """The reply is longer than any answer."""


class Endpoint:
    """`url`/chat/completions, with the key of the environment."""

    def __init__(self, options: VlmConfig, sleep: Callable[[float], None] = time.sleep) -> None:
        self.options, self._sleep = options, sleep

    def key(self) -> str:
        """The key; empty if none is asked for.

        Raises:
            InputError: the variable is not set, or holds what cannot be sent.
        """
        name = self.options.key_env
        key = os.environ.get(name, "").strip() if name else ""
        where = f"environment variable {name}"
        if name and not key:
            mend = "export it; or vlm.key_env: '' for a server without keys, or vlm.mode: replay"
            raise InputError(where, "is not set, and the ledger lacks a call.", mend, code="E-VLM-KEY")
        if not (key.isascii() and key.isprintable()):
            fix = "set it to the key and nothing else"
            raise InputError(where, "holds characters that no key has.", fix, code="E-VLM-KEY")
        return key

    def post(self, body: dict[str, Any], allow: Callable[[], None]) -> dict[str, Any]:
        """The reply to a request; `allow` is called before every attempt, and may raise.

        Raises:
            UnreachedError, RefusedError, OversizedError: see there.
            InputError: key, model or address are wrong, or the account is empty: no other request would do better.
        """
        why, wanted = "", None
        for pause in (0, *PAUSES):
            if pause:
                self._sleep(pause if wanted is None else min(wanted, LONGEST_PAUSE))
            allow()
            wanted = None
            try:
                return self._send_once(body)
            except HTTPError as error:
                message = self._message(error)
                self._give_up(error.code, message)
                wanted, why = _read_retry_after(error.headers), f"HTTP {error.code}: {message}".rstrip(": ")
                if wanted is not None and wanted > LATER:
                    raise UnreachedError(f"{why}; not before {wanted / 3600:.3g} hours") from None
            except TimeoutError:
                why = f"no reply within {self.options.timeout:g} s"
            except (OSError, HTTPException, ValueError) as error:
                why = f"{type(error).__name__}: {self.quote_server(str(getattr(error, 'reason', error)))}"[:SHOWN]
        raise UnreachedError(why)

    def _send_once(self, body: dict[str, Any]) -> dict[str, Any]:
        """One attempt."""
        headers = {"Content-Type": "application/json", "Accept": "application/json"}
        if key := self.key():
            headers["Authorization"] = f"Bearer {key}"
        data = json.dumps(body, ensure_ascii=False).encode()
        request = Request(f"{self.options.url}/chat/completions", data, headers, method="POST")
        received, content = response_to(request, self.options.timeout)
        if len(content) > MAX_REPLY:
            raise OversizedError(f"a reply of more than {MAX_REPLY} bytes")
        if len(content) < int(received.get("Content-Length") or 0):
            raise HTTPException("the reply is cut off")
        try:
            reply = json.loads(content)
        except (ValueError, RecursionError):
            raise HTTPException("the reply is no JSON") from None
        if not isinstance(reply, dict):
            raise HTTPException("the reply is no JSON object")
        return reply

    def _give_up(self, status: int, message: str) -> None:
        """Raise what waiting does not mend."""
        where, key = self.options.url, f"the key in {self.options.key_env}" if self.options.key_env else "a key"
        if status in (401, 403):
            raise InputError(
                where, f"refuses {key} (HTTP {status}).", "set another, see vlm.key_env", code="E-VLM-KEY"
            ) from None
        if status in (404, 405):
            raise InputError(
                where, f"HTTP {status}: {message}", "correct vlm.url or vlm.model", code="E-VLM-ADDRESS"
            ) from None
        if status == 402 or "insufficient_quota" in message:
            raise InputError(
                where, f"HTTP {status}: the account has nothing left.", "pay, or use another", code="E-VLM-ACCOUNT"
            ) from None
        if 300 <= status < 400:
            raise InputError(
                where, f"answers with a redirect (HTTP {status}).", "give its target as vlm.url", code="E-VLM-ADDRESS"
            ) from None
        if status < 500 and status not in BUSY:
            raise RefusedError(status, message) from None

    def _message(self, error: HTTPError) -> str:
        """What the server says of an error, in one line."""
        try:
            text = error.read().decode("utf-8", "replace")
        except (OSError, HTTPException):
            return ""
        try:
            content = json.loads(text)
            found = content.get("error", content)
            if isinstance(found, dict):
                found = " ".join(str(found[name]) for name in ("code", "message") if found.get(name))
            text = str(found)
        except (ValueError, AttributeError, RecursionError):
            pass
        return self.quote_server(text)

    def quote_server(self, text: str) -> str:
        """What a server says, in one line that may be shown."""
        return escape_control(self.hide_key(" ".join(text.split())[:LONGEST])[:SHOWN])

    def hide_key(self, text: str) -> str:
        """Text without the key, should a server repeat it, and without halves of characters, which no file holds."""
        key = os.environ.get(self.options.key_env, "").strip() if self.options.key_env else ""
        return hide_key(text.encode("utf-8", "replace").decode("utf-8"), key)


def _read_retry_after(headers: Message) -> float | None:
    """Seconds that a server asks to wait: `Retry-After` as a number or a date."""
    text = headers.get("Retry-After", "")
    try:
        return max(0.0, float(text)) if text else None
    except ValueError:
        pass
    try:
        return max(0.0, (parsedate_to_datetime(text) - datetime.now(UTC)).total_seconds())
    except (ValueError, TypeError, OverflowError):
        return None
