"""The page's server: this machine alone, one secret address, a fixed list of names, no file paths from outside."""

import json
import re
import secrets
import sys
from collections.abc import Callable
from hmac import compare_digest
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Lock, Thread
from typing import Any

from pydantic import ValidationError

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.kept import OutdatedError
from roomkin.plugins.annotator.making import Making
from roomkin.plugins.annotator.session import Session
from roomkin.stages.contracts.errors import InputError, explain, first_error
from roomkin.stages.contracts.system import line_of

HERE = Path(__file__).resolve().parent
PAGES = {"page.css": "text/css; charset=utf-8"}
PAGES |= {path.name: "text/javascript; charset=utf-8" for path in HERE.glob("*.js")}
Page = Session | Correcting
OF_SERVER = {"make", "stop", "turn"}
NEWEST = {"save", "write", "close", *OF_SERVER}  # what only the newest page may ask for
OPENED_AGAIN = "this drawing was opened again in another tab: go on there, or reload this one"
MAX_REQUEST = 2_000_000  # bytes of a request: no drawing comes near
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
POLICY += "connect-src 'self'; base-uri 'none'"


class Handler(BaseHTTPRequestHandler):
    """Answers `/<token>/<name>` for known names; everything else is 404 and tells nothing."""

    server: "PageServer"
    protocol_version = "HTTP/1.1"
    timeout = 30

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing on the terminal: it is where the command's own lines stand."""

    def _name(self) -> str | None:
        """The part after the token, if the request is for us."""
        token, slash, name = self.path.partition("?")[0].removeprefix("/").partition("/")
        hosts = (f"127.0.0.1:{self.server.server_port}", f"localhost:{self.server.server_port}")
        ours = self.headers.get("Host") in hosts
        origin = self.headers.get("Origin")
        ours = ours and (origin is None or origin in [f"http://{host}" for host in hosts])
        return name if compare_digest(token.encode(), self.server.token.encode()) and ours and slash else None

    def _reply(self, status: int, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.end_headers()
        self.wfile.write(body)

    def _json(self, status: int, answer: Any) -> None:
        self._reply(status, "application/json", json.dumps(answer, allow_nan=False).encode())

    def _refuse(self, status: int, why: str) -> None:
        self.close_connection = True  # what is left of the request is not read
        self._json(status, {"error": why})

    def _fail(self, error: Exception) -> None:
        """Report what the operating system refused, unless the connection is gone."""
        if isinstance(error, ConnectionError | TimeoutError):
            raise error
        print(f"error: {line_of(error)}", file=sys.stderr)
        self._refuse(500, str(line_of(error)))

    def do_GET(self) -> None:
        """The page, its picture, and what was drawn."""
        name, session = self._name(), self.server.session
        try:
            if name == "":
                self._reply(200, "text/html; charset=utf-8", (HERE / session.page).read_bytes())
            elif name is not None and name in PAGES:
                self._reply(200, PAGES[name], (HERE / name).read_bytes())
            elif name == "picture.jpg":
                self._reply(200, "image/jpeg", session.picture())
            elif name == "made.png" and (made := session.find_last_picture()):
                self._reply(200, "image/png", made.read_bytes())
            elif name == "start":
                self._json(200, self.server.open_page())
            elif name == "making":
                self._json(200, self.server.making.describe())
            elif name == "ready":
                self._json(200, session.ready())
            elif name == "preview.jpg":
                with self.server.lock:
                    self._reply(200, "image/jpeg", session.preview())
            else:
                self._refuse(404, "no such page")
        except InputError as error:
            self._refuse(400, str(error))
        except (OSError, MemoryError) as error:
            self._fail(error)

    def do_POST(self) -> None:
        """One of the session's commands, with a JSON body."""
        name = self._name()
        session = self.server.session
        if name not in (*session.posts, *OF_SERVER):
            return self._refuse(404, "no such page")
        length = self.headers.get("Content-Length", "")
        if not re.fullmatch("[0-9]{1,18}", length):
            return self._refuse(400, "the length of the drawing is no number")
        if int(length) > MAX_REQUEST:
            return self._refuse(413, "the drawing is too large")
        if self.headers.get("Content-Type") != "application/json":
            return self._refuse(415, "not JSON")
        try:
            body = json.loads(self.rfile.read(int(length)))
            answer = self._answer(name, body)
        except OutdatedError as error:
            return self._refuse(409, str(error))
        except InputError as error:
            return self._refuse(400, str(error))
        except ValidationError as error:
            return self._refuse(400, f"the drawing breaks its contract at {first_error(error)}")
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            return self._refuse(400, f"not a drawing ({explain(error)})")
        except (OSError, MemoryError) as error:
            return self._fail(error)
        self._json(200, answer)
        if session.finished:
            Thread(target=self.server.shutdown).start()  # from this thread it would wait for itself

    def _answer(self, name: str, body: Any) -> Any:
        """What the session answers; saving does not wait for what is computed."""
        server, session = self.server, self.server.session
        if name in NEWEST:
            with session.kept.lock:
                if self.headers.get("X-Page", "1") != str(server.opened or 1):
                    raise OutdatedError(OPENED_AGAIN)
                if name == "close":
                    return session.close(body)
                if name == "make":
                    server.making.start(session.command())
                elif name == "stop":
                    server.making.stop()
                elif name == "turn":
                    server.turn()
                if name in OF_SERVER:
                    return {}
                edits = int(self.headers.get("X-Edits", server.edits))
                if edits >= server.edits:  # else it was overtaken by a newer one
                    session.save(body)
                    server.edits = edits
            if name == "save":
                return {}
        with server.lock:
            return getattr(session, name)(body)


class PageServer(ThreadingHTTPServer):
    """Serves one session at `address` until it is closed; with `other`, the other page of its picture in its place."""

    daemon_threads = True

    def __init__(self, session: Page, port: int = 0, other: Callable[[], Page] | None = None) -> None:
        super().__init__(("127.0.0.1", port), Handler)
        self.session, self._other = session, other
        self.token = secrets.token_urlsafe(24)
        self.lock = Lock()
        self.making = Making()
        self.opened = 0  # pages: only the newest may write
        self.edits = 0  # of the newest page, that are saved

    def open_page(self) -> dict[str, Any]:
        """What a page begins with, which is the newest from now on."""
        if self.making.is_new() and isinstance(self.session, Correcting):
            self.session.__post_init__()  # it shows what was made
        with self.session.kept.lock:
            self.opened, self.edits = self.opened + 1, 0
            self.session.kept.look()
            return {**self.session.start(), "page": self.opened, "other": self._other is not None}

    def turn(self) -> None:
        """Show the other page of the same picture at the address from now on."""
        if self._other is None:
            raise InputError("the other page", "is not there.", "go on here", code="E-OPTION-CONFLICT")
        before, self.session = self.session, self._other()
        self._other = lambda: before
        if isinstance(self.session, Correcting):
            self.session.__post_init__()  # it shows what was written and made meanwhile
        if self.session.clicker is None:
            self.session.begin_looking()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A page that was closed or reloaded in the middle of an answer is no error."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)

    @property
    def address(self) -> str:
        """The page's address, which nobody can guess."""
        return f"http://127.0.0.1:{self.server_port}/{self.token}/"
