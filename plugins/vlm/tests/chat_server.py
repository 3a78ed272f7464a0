"""A local server that speaks the protocol of OpenAI's chat endpoint, and misbehaves as it is told."""

import base64
import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

import cv2
import numpy as np

KEY = "sk-test-7f3a9c"
Step = Callable[["Handler", dict[str, Any]], None]


class Handler(BaseHTTPRequestHandler):
    """Checks the request as the real one would, then takes the next step of the script."""

    server: "ChatServer"

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.requests.append(body)
        assert self.path == "/v1/chat/completions"
        if self.server.key and self.headers["Authorization"] != f"Bearer {self.server.key}":
            return self.send(401, {"error": {"code": "invalid_api_key", "message": self.headers["Authorization"]}})
        check(body)
        steps = self.server.steps
        (steps.pop(0) if len(steps) > 1 else steps[0])(self, body)

    def send(self, status: int, content: Any, **headers: str) -> None:
        data = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.send_response(status)
        given = {name.replace("_", "-"): value for name, value in headers.items()}
        for name, value in {"Content-Length": str(len(data)), **given}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, *_: Any) -> None:
        pass


class ChatServer(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False

    def __init__(self, steps: list[Step], key: str = "") -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.steps, self.key, self.requests = steps, key, []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}/v1"

    def handle_error(self, *_: Any) -> None:
        """The client hung up, as it may."""


@contextmanager
def serving(*steps: Step, key: str = "") -> Iterator[ChatServer]:
    with ChatServer(list(steps), key) as server:
        Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        yield server
        server.shutdown()


def check(body: dict[str, Any]) -> None:
    """What a request must be: roles, texts, pictures that are pictures, a strict schema if there is one."""
    assert body["model"] and body["messages"][0]["role"] == "system"
    assert [message["role"] for message in body["messages"]][1::2] == ["user"] * (len(body["messages"]) // 2)
    assert all(picture.ndim == 3 for picture in pictures(body))
    form = body.get("response_format")
    if form and form["type"] == "json_schema":
        schema = form["json_schema"]["schema"]
        assert form["json_schema"]["strict"] and schema["additionalProperties"] is False
        assert sorted(schema["required"]) == sorted(schema["properties"])


def pictures(body: dict[str, Any]) -> list[np.ndarray]:
    """The pictures (red first) that a request shows."""
    parts = [
        part for message in body["messages"] if isinstance(message["content"], list) for part in message["content"]
    ]
    urls = [part["image_url"]["url"] for part in parts if part["type"] == "image_url"]
    assert all(url.startswith("data:image/png;base64,") for url in urls)
    files = [np.frombuffer(base64.b64decode(url.partition(",")[2]), np.uint8) for url in urls]
    return [cv2.imdecode(file, cv2.IMREAD_COLOR)[..., ::-1] for file in files]


def reply(text: Any, finish: str = "stop", usage: Any = (1000, 20), **message: Any) -> dict[str, Any]:
    """A chat completion."""
    counted = {"usage": {"prompt_tokens": usage[0], "completion_tokens": usage[1]}} if usage else {}
    message = {"role": "assistant", "content": text, **message}
    choices = [{"index": 0, "message": message, "finish_reason": finish}]
    return {"object": "chat.completion", "model": "toy-2026", "choices": choices, **counted}


def says(text: Any, **more: Any) -> Step:
    return lambda handler, body: handler.send(200, reply(text, **more))


def chooses(choice: str, **more: Any) -> Step:
    return says(json.dumps({"reason": "it looks like it", "choice": choice}), **more)


def fails(status: int, message: str = "", **headers: str) -> Step:
    pause = {"Retry_After_Ms": "1", **headers}
    return lambda handler, body: handler.send(status, {"error": {"code": "", "message": message}}, **pause)


def sends(data: bytes, **headers: str) -> Step:
    return lambda handler, body: handler.send(200, data, **headers)


def sleeps(seconds: float) -> Step:
    return lambda handler, body: time.sleep(seconds)


def hangs_up(handler: Handler, body: dict[str, Any]) -> None:
    handler.close_connection = True


def only(kind: str | None, then: Step, status: int = 400) -> Step:
    """A server that knows no other format."""

    def step(handler: Handler, body: dict[str, Any]) -> None:
        asked = body.get("response_format", {}).get("type")
        (then if asked == kind else fails(status, f"response_format {asked} is not supported"))(handler, body)

    return step
