"""Requests that end at a time, whatever the server does: socket timeouts alone bound each wait, not their sum."""

import contextlib
import io
import socket
import time
from collections.abc import Iterator
from http.client import HTTPConnection, HTTPException, HTTPResponse, HTTPSConnection
from threading import Timer
from typing import Any
from urllib.error import HTTPError
from urllib.request import HTTPHandler, HTTPRedirectHandler, HTTPSHandler, Request, build_opener

LARGEST = 1_000_000  # bytes of a reply; answers are short


class _NoRedirect(HTTPRedirectHandler):
    """A redirect would carry the key to another host."""

    def redirect_request(self, *_: Any) -> None:
        return None


class _Kept:
    """A connection whose socket is remembered."""

    sockets: list[socket.socket]
    sock: socket.socket

    def connect(self) -> None:
        super().connect()  # type: ignore[misc]
        self.sockets.append(self.sock)


@contextlib.contextmanager
def opened(request: Request, seconds: float) -> Iterator[HTTPResponse]:
    """The response to a request; everything that is read of it, headers too, ends after so many seconds.

    Raises:
        TimeoutError: it took longer.
        HTTPError, OSError, HTTPException: as urllib's.
    """
    sockets: list[socket.socket] = []
    plain: Any = type("Plain", (_Kept, HTTPConnection), {"sockets": sockets})
    secure: Any = type("Secure", (_Kept, HTTPSConnection), {"sockets": sockets})

    class Plainly(HTTPHandler):
        def http_open(self, request: Request) -> HTTPResponse:
            return self.do_open(plain, request)

    class Securely(HTTPSHandler):
        def https_open(self, request: Request) -> HTTPResponse:
            return self.do_open(secure, request)

    def cut() -> None:
        for each in sockets:
            with contextlib.suppress(OSError):
                socket.socket.shutdown(each, socket.SHUT_RDWR)  # reading ends at once

    end = time.monotonic() + seconds
    timer = Timer(seconds, cut)
    timer.daemon = True
    timer.start()
    try:
        with build_opener(_NoRedirect, Plainly, Securely).open(request, timeout=seconds) as response:
            yield response
        if time.monotonic() >= end:
            raise TimeoutError
    except HTTPError as error:
        body = b""
        with contextlib.suppress(OSError, HTTPException):
            body = error.read(LARGEST)
        raise HTTPError(error.url, error.code, error.msg, error.headers, io.BytesIO(body)) from None
    except (OSError, HTTPException) as error:
        if time.monotonic() >= end:
            raise TimeoutError from error
        raise
    finally:
        timer.cancel()
