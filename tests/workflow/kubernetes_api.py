"""As much of a Kubernetes API as Snakemake's executor asks for: every pod's command really runs, in an empty folder."""

import base64
import json
import os
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

ROOT = Path(__file__).resolve().parents[2]  # its package is what an image has
CONFIG = """\
apiVersion: v1
kind: Config
clusters: [{{name: here, cluster: {{server: "http://127.0.0.1:{port}"}}}}]
users: [{{name: me, user: {{}}}}]
contexts: [{{name: here, context: {{cluster: here, user: me}}}}]
current-context: here
"""


class Cluster(ThreadingHTTPServer):
    """`jobs`: what was submitted, by name; `exits`: exit codes of those that ended; `path`: of the pods' programs.

    One pod runs at a time.
    """

    def __init__(self, path: str) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.path = path
        self.jobs: dict[str, Any] = {}
        self.exits: dict[str, int] = {}
        self.output: dict[str, str] = {}
        self.secrets: dict[str, dict[str, str]] = {}
        self.node = threading.Lock()

    def run(self, name: str) -> None:
        """Run the command of a job's pod as its node would, in an empty folder, with nothing of this environment."""
        (container,) = self.jobs[name]["spec"]["template"]["spec"]["containers"]
        given = {"PATH": self.path, "PYTHONPATH": str(ROOT), "HOME": "/nonexistent", "LANG": "C.UTF-8"}
        for variable in container.get("env") or []:
            secret = variable["valueFrom"]["secretKeyRef"]
            given[variable["name"]] = base64.b64decode(self.secrets[secret["name"]][secret["key"]]).decode()
        with self.node, tempfile.TemporaryDirectory(prefix="pod-") as workdir:
            given |= {"TMPDIR": workdir, "XDG_CACHE_HOME": f"{workdir}/.cache"}
            command = [*container["command"], *container["args"]]
            done = subprocess.run(command, cwd=workdir, env=given, capture_output=True, text=True)
        self.output[name] = done.stdout + done.stderr
        self.exits[name] = done.returncode


class Handler(BaseHTTPRequestHandler):
    """Secrets, jobs and their pods of one namespace."""

    server: Cluster

    def do_POST(self) -> None:
        """Keep a secret, or start a job."""
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        name = body["metadata"]["name"]
        if self.path.endswith("/secrets"):
            self.server.secrets[name] = body["data"]
        else:
            self.server.jobs[name] = body
            threading.Thread(target=self.server.run, args=(name,), daemon=True).start()
        self._answer(body, 201)

    def do_GET(self) -> None:
        """The state of a job, its pods, or what one printed."""
        url = urlsplit(self.path)
        parts = url.path.split("/")
        if parts[-1] == "log":
            self._answer(self.server.output[parts[-2]])
        elif parts[-1] == "pods":
            name = parse_qs(url.query)["labelSelector"][0].removeprefix("job-name=")
            self._answer({"kind": "PodList", "items": [self._pod(name)]})
        else:
            code = self.server.exits.get(parts[-2])
            ended = {} if code is None else {"failed" if code else "succeeded": 1}
            self._answer(self.server.jobs[parts[-2]] | {"status": ended})

    def do_DELETE(self) -> None:
        """Nothing is kept."""
        self._answer({"kind": "Status", "status": "Success"})

    def _pod(self, name: str) -> dict[str, Any]:
        code = self.server.exits.get(name)
        state = {"running": {}} if code is None else {"terminated": {"exitCode": code}}
        about = {"name": "snakemake", "image": "", "imageID": "", "ready": True, "restartCount": 0, "state": state}
        return {"metadata": {"name": name}, "status": {"containerStatuses": [about]}}

    def _answer(self, body: object, code: int = 200) -> None:
        content = body.encode() if isinstance(body, str) else json.dumps(body).encode()
        self.send_response(code)
        self.send_header("Content-Type", "text/plain" if isinstance(body, str) else "application/json")
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: object) -> None:
        """Silent."""


@contextmanager
def cluster(folder: Path, python: Path) -> Iterator[Cluster]:
    """A cluster whose pods have the programs beside `python`; its kubeconfig is written into `folder`.

    Snakemake has every pod install its storage plugin by pip. The image of these pods has it: their pip does nothing.
    """
    tools = folder / "tools"
    tools.mkdir(parents=True)
    (tools / "pip").write_text("#!/bin/sh\n")
    (tools / "pip").chmod(0o755)
    server = Cluster(os.pathsep.join([str(tools), str(python.parent), "/usr/bin", "/bin"]))
    (folder / "kubeconfig").write_text(CONFIG.format(port=server.server_port))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield server
    finally:
        server.shutdown()
