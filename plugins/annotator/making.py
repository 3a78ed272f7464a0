"""A run of the workflow that a page starts, watches and stops: one fixed command, nothing that a request says."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from threading import Thread
from typing import Any

from roomkin.stages.contracts.errors import InputError

ENDED = re.compile(r"\[ *(\d+)/(\d+)\] ")  # a job, as `roomkin.stages.run_log` prints it
COUNT = re.compile(r"(\d+) jobs, a line as each ends")
PATIENCE = 10.0  # seconds that Snakemake has to end its jobs


class Making:
    """The run of a page's command, if there was one."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self._reader: Thread | None = None  # lives until the last line is read
        self._done, self._total, self._line, self._stopped, self._seen = 0, 0, "", False, True

    def start(self, command: str) -> None:
        """Run a command line as `to_run` writes it, unless a run goes on.

        Raises:
            InputError: the workflow is not here.
        """
        if self.describe()["running"]:
            return
        words, folder = shlex.split(command), None
        if words[0] == "cd":
            folder, words = Path(words[1]), words[3:]
            if not folder.is_dir():
                raise InputError("the workflow", "is not here.", f"in its clone: {command}", code="E-FOLDER-MISSING")
        program = Path(sys.executable).with_name(words[0])
        self._done, self._total, self._line, self._stopped, self._seen = 0, 0, "it begins", False, False
        self._process = subprocess.Popen(
            [str(program) if program.is_file() else words[0], *words[1:]], cwd=folder, start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
            env={name: value for name, value in os.environ.items() if name != "VERBOSE"} | {"PYTHONUNBUFFERED": "1"},
        )  # fmt: skip
        self._reader = Thread(target=self._read, args=(self._process,), daemon=True)
        self._reader.start()

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:  # bars, which return to their beginning, are lines too
            if ended := ENDED.match(line):
                self._done, self._total = map(int, ended.groups())
            elif count := COUNT.match(line):
                self._total = int(count[1])
            self._line = ENDED.sub("", line).strip() or self._line
        process.wait()

    def describe(self) -> dict[str, Any]:
        """Whether it runs, how many jobs of how many have ended, its last line, and how it ended (None: it did not)."""
        running = self._reader is not None and self._reader.is_alive()
        code = self._process.poll() if self._process and not running else None
        if self._stopped and not running:
            self._line, code = "stopped; what was made is kept", -signal.SIGINT
        return {"running": running, "done": self._done, "total": self._total, "line": self._line, "code": code}

    def stop(self) -> None:
        """End the run as Ctrl-C does; it goes on from there when it is started again."""
        if self._process is None or not self.describe()["running"]:
            return
        self._stopped = True
        for sign in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(self._process.pid, sign)
                self._process.wait(PATIENCE)
                return None if self._reader is None else self._reader.join(PATIENCE)
            except subprocess.TimeoutExpired:
                continue
            except ProcessLookupError:
                return

    def is_new(self) -> bool:
        """Whether a run has ended since this was last asked."""
        ended = self.describe()["code"] is not None
        ended, self._seen = ended and not self._seen, self._seen or ended
        return ended
