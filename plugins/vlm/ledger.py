"""The ledger: one JSON file per question and model, named by what was asked. What is in it is never asked again."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, NamedTuple

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, Document, read_json, write_json
from roomkin.stages.contracts.types import Count, NonNegative, Text

AGAIN = "delete the file, and it is asked again"


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
