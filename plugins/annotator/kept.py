"""The file that a page keeps, which others may write, too: what they wrote is not overwritten."""

from pathlib import Path
from threading import Lock
from typing import Any

from roomkin.stages.contracts.files import as_json, write_text
from roomkin.stages.contracts.system import lock_folder


class OutdatedError(Exception):
    """A page may not write: there is something newer than what it shows."""


class Kept:
    """A file as it was last read or written here. Whoever reads and then writes holds `lock`."""

    def __init__(self, path: Path) -> None:
        self.path, self.lock = path, Lock()
        self.look()

    def look(self) -> None:
        """Take the file as it is now: what is written next comes in its place."""
        self._known = self._read()

    def write(self, value: Any) -> None:
        """Replace the file by a contract or plain data as JSON.

        Raises:
            OutdatedError: others have changed it since.
        """
        text = as_json(value)
        if self._read() == text.encode():
            return self.look()
        with lock_folder(self.path.parent):
            if self._read() != self._known:
                what = "was changed since this page was opened, by another page or program"
                raise OutdatedError(f"{self.path} {what}: reload to go on from there; what is here is not saved")
            try:
                write_text(self.path, text)
            finally:
                self.look()  # also after an error: the file may have been replaced by then

    def _read(self) -> bytes | None:
        return self.path.read_bytes() if self.path.is_file() else None
