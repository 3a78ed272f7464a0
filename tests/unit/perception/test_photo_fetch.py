"""Weights of networks, fetched from a local server that answers as the hub does."""

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from roomkin.stages.config.perception import PerceptionSection
from roomkin.stages.config.weights import NETWORKS
from roomkin.stages.perception.fetch import RECORD, fetch_weights

COMMIT = "c0ffee" * 6 + "cafe"
FILES = {"config.json": b"{}", "model.safetensors": b"weights " * 1000, "vocab.txt": b"mug", "model.bin": b"no"}


class Hub(BaseHTTPRequestHandler):
    broken = False
    requests: list[str] = []

    def do_GET(self) -> None:
        self.requests.append(self.path)
        path = self.path.partition("?")[0]
        name = path.rpartition("/")[2]
        if path.startswith("/api/models/toy/net/revision/") and name in ("main", COMMIT):
            self.answer(json.dumps({"id": "toy/net", "sha": COMMIT, "siblings": [{"rfilename": n} for n in FILES]}))
        elif path.startswith("/api/models/toy/net/tree/"):
            self.answer(json.dumps([{"type": "file", "path": n, "size": len(d), "oid": n} for n, d in FILES.items()]))
        elif path.startswith(f"/toy/net/resolve/{COMMIT}/") and not (Hub.broken and name == "model.safetensors"):
            self.answer(FILES[name], ETag=f'"{hashlib.sha1(FILES[name]).hexdigest()}"')
        else:
            self.answer("nothing", 404)

    def do_HEAD(self) -> None:
        self.do_GET()

    def answer(self, text: str | bytes, status: int = 200, **headers: str) -> None:
        data = text if isinstance(text, bytes) else text.encode()
        self.send_response(status)
        for key, value in {"Content-Length": str(len(data)), "X-Repo-Commit": COMMIT, **headers}.items():
            self.send_header(key, value)
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(data)

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture
def hub() -> Iterator[str]:
    Hub.requests, Hub.broken = [], False
    with ThreadingHTTPServer(("127.0.0.1", 0), Hub) as server:
        Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


def fetch(folder: Path, hub: str) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own: the hub's address is read when its library is imported."""
    names = ("detector", "segmenter", "depth_anything")
    options = json.dumps(dict.fromkeys(names, str(folder / "net")))
    sources = json.dumps(dict.fromkeys(names, "toy/net"))
    command = [
        sys.executable,
        "-m",
        "roomkin.stages.perception",
        "fetch",
        "--networks",
        "--options",
        options,
        "--sources",
        sources,
    ]
    command += ["--out", str(folder / "all.json"), "--lock", str(folder / "weights.lock.json")]
    environment = os.environ | {
        "HF_ENDPOINT": hub,
        "HF_HOME": str(folder / "home"),
        "HF_HUB_DISABLE_PROGRESS_BARS": "1",
    }
    return subprocess.run(command, env=environment, text=True, capture_output=True)


def test_weights_come_once_and_say_what_they_are(hub: str, tmp_path: Path) -> None:
    Hub.broken = True
    done = fetch(tmp_path, hub)
    assert done.returncode == 1 and not (tmp_path / "all.json").exists()
    assert "E-WEIGHTS-DOWNLOAD" in done.stderr and "what came stays" in done.stderr
    assert "Traceback" not in done.stderr
    Hub.broken, Hub.requests = False, []
    done = fetch(tmp_path, hub)
    assert done.returncode == 0, done.stderr
    assert not [path for path in Hub.requests if path.endswith("/model.bin")]
    record = json.loads((tmp_path / "all.json").read_text())["detector"]
    (locked,) = json.loads((tmp_path / "weights.lock.json").read_text()).items()
    assert locked == ("toy/net", {"commit": COMMIT, "sha256": record["sha256"]})
    assert done.stdout.count("from now on; keep the file") == 1  # three networks of one source
    assert record["commit"] == COMMIT and record["sha256"] == hashlib.sha256(FILES["model.safetensors"]).hexdigest()
    assert (tmp_path / "net/vocab.txt").read_bytes() == b"mug"
    again = fetch_weights(str(tmp_path / "net"), "toy/net", "perception.detector")  # nobody is asked
    assert again["commit"] == COMMIT


def test_the_next_machine_gets_the_same_bytes_or_an_error(hub: str, tmp_path: Path) -> None:
    lock = tmp_path / "weights.lock.json"
    sha256 = hashlib.sha256(FILES["model.safetensors"]).hexdigest()
    lock.write_text(json.dumps({"toy/net": {"commit": COMMIT, "sha256": sha256}}))
    assert fetch(tmp_path, hub).returncode == 0
    assert any(path.startswith(f"/api/models/toy/net/revision/{COMMIT}") for path in Hub.requests)
    assert not any("revision/main" in path for path in Hub.requests)
    lock.write_text(json.dumps({"toy/net": {"commit": COMMIT, "sha256": "0" * 64}}))
    done = fetch(tmp_path, hub)  # what lies here is looked at, too
    assert done.returncode == 1 and f"has sha256 {sha256}, locked is 0000" in done.stderr
    lock.write_text('{"toy/net": {"commit": "main"}}')
    done = fetch(tmp_path, hub)
    assert done.returncode == 1 and "weights.lock.json: is broken at" in done.stderr and "Traceback" not in done.stderr


def test_weights_that_are_not_the_locked_ones_are_refused_when_they_come(hub: str, tmp_path: Path) -> None:
    (tmp_path / "weights.lock.json").write_text(json.dumps({"toy/net": {"commit": COMMIT, "sha256": "0" * 64}}))
    done = fetch(tmp_path, hub)
    assert done.returncode == 1 and "E-WEIGHTS-CHECKSUM" in done.stderr
    assert not (tmp_path / "net" / RECORD).exists() and not (tmp_path / "all.json").exists()


def test_weights_of_ones_own_stay(tmp_path: Path) -> None:
    for name in ("config.json", "model.safetensors"):
        (tmp_path / name).write_bytes(FILES[name])
    found = fetch_weights(str(tmp_path), "toy/other", "perception.detector")
    assert found["sha256"] == hashlib.sha256(FILES["model.safetensors"]).hexdigest() and "commit" not in found


def test_only_the_networks_that_are_used_are_fetched() -> None:
    assert list(PerceptionSection().networks()) == ["detector", "segmenter", "depth_anything"]
    assert set(PerceptionSection().networks()) == set(NETWORKS)
