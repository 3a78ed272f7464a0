"""Requests that end at a time, whatever the server does: socket timeouts alone bound each wait, not their sum."""

import io
from contextlib import suppress
from email.message import Message
from http.client import HTTPException
from queue import Empty, Queue
from threading import Thread
from typing import Any, NamedTuple
from urllib.error import HTTPError
from urllib.request import HTTPRedirectHandler, Request, build_opener

MAX_REPLY = 1_000_000  # bytes of a reply; answers are short


class Response(NamedTuple):
    """Headers and body of a response; of a body of more than `MAX_REPLY` bytes one byte more than that."""

    headers: Message
    body: bytes


class _NoRedirect(HTTPRedirectHandler):
    """A redirect would carry the key to another host."""

    def redirect_request(self, *_: Any) -> None:
        return None


def response_to(request: Request, seconds: float) -> Response:
    """The whole response to a request, within so many seconds.

    Raises:
        TimeoutError: it took longer; a thread then goes on reading until the server stops sending.
        HTTPError, OSError, HTTPException: as urllib's.
    """
    found: Queue[Response | Exception] = Queue()

    def read() -> None:
        try:
            with build_opener(_NoRedirect).open(request, timeout=2 * seconds) as response:
                found.put(Response(response.headers, response.read(MAX_REPLY + 1)))
        except HTTPError as error:
            body = b""
            with suppress(OSError, HTTPException):
                body = error.read(MAX_REPLY)
            found.put(HTTPError(error.url, error.code, error.msg, error.headers, io.BytesIO(body)))
        except Exception as error:  # raised again by whoever waits
            found.put(error)

    Thread(target=read, daemon=True).start()
    try:
        result = found.get(timeout=seconds)
    except Empty:
        raise TimeoutError from None
    if isinstance(result, Exception):
        raise result
    return result
