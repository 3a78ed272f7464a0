"""No save is lost: not to another page or program, a newer save, a long computation, a full disk or a kill."""

import errno
import http.client
import json
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Barrier, Event, Thread
from typing import Any

import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.annotator import correcting, session
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.kept import Kept, OutdatedError
from roomkin.plugins.annotator.server import PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.plugins.annotator.tests.annotate_page import serve
from roomkin.plugins.annotator.tests.test_correcting import BOXES
from roomkin.stages.contracts import files
from roomkin.stages.contracts.hand import CORRECTIONS, PROJECT
from roomkin.stages.perception.read.photo import read_photo
from tests.unit.synthetic_room import write_room

DRAWN = "drawn_90"
SQUARE = [[100, 100], [160, 100], [160, 150], [100, 150]]
Open = Callable[[], PageServer]


@pytest.fixture(params=["draws", "corrects"])
def opens(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Open]:
    """Opens a server of one photograph, or of one input folder; as often as it is called."""
    servers = []
    if request.param == "corrects":
        write_room(tmp_path / "out", BOXES, ["cabinet", "box"])
    else:
        noise = np.random.default_rng(0).integers(0, 255, (240, 320, 3), dtype=np.uint8)
        Image.fromarray(noise).save(tmp_path / "a.png")

    def start() -> PageServer:
        if request.param == "corrects":
            opened: Any = Correcting(tmp_path / "out", [], tmp_path / "results", "kitchen")
        else:
            opened = Session(read_photo(tmp_path / "a.png"), "a.png", tmp_path / "out")
        servers.append(serve(opened))
        return servers[-1]

    yield start
    for server in servers:
        server.shutdown()
        server.server_close()


class Page:
    """What a page of a server asks."""

    def __init__(self, server: PageServer) -> None:
        self.server = server
        status, answer = self._send("GET", "start", None, {})
        assert status == 200
        self.number, self.project = answer["page"], answer["project"]
        self.others = [item for item in self.project["objects"] if item["id"] != DRAWN]

    def _send(self, method: str, name: str, body: Any, headers: dict[str, str]) -> tuple[int, Any]:
        link = http.client.HTTPConnection("127.0.0.1", self.server.server_port, timeout=20)
        headers = {"Content-Type": "application/json", **headers}
        link.request(method, f"/{self.server.token}/{name}", json.dumps(body), headers)
        reply = link.getresponse()
        return reply.status, json.loads(reply.read())

    def post(self, name: str, label: str = "mug", edits: int = 1) -> tuple[int, str]:
        """The status and the error of a command, for the drawing in which a person has drawn one thing."""
        thing: dict[str, Any] = {"id": DRAWN, "label": label}
        thing |= {"mask": 90, "outline": SQUARE} if self.corrects else {"points": [[100, 150], [160, 150], [160, 100]]}
        body = self.project | {"objects": [*self.others, thing]}
        headers = {"X-Page": str(self.number), "X-Edits": str(edits)}
        status, answer = self._send("POST", name, body, headers)
        return status, answer.get("error", "")

    @property
    def corrects(self) -> bool:
        return isinstance(self.server.session, Correcting)

    @property
    def path(self) -> Path:
        return self.server.session.kept.path

    def labels(self) -> list[str]:
        """Labels of what a person has drawn, as it is kept."""
        said = json.loads(self.path.read_text())["objects"]
        return [item["label"] for item in said if item.get("id", DRAWN) == DRAWN]


def test_of_two_servers_of_one_folder_the_later_must_reload(opens: Open) -> None:
    one, other = Page(opens()), Page(opens())
    assert one.path.name == (CORRECTIONS if one.corrects else PROJECT)
    assert one.post("save", "mug")[0] == 200
    for command in ("save", "write"):
        status, why = other.post(command, "bowl")
        assert status == 409 and f"{one.path} was changed since this page was opened" in why and "reload" in why
    assert one.labels() == ["mug"] and one.post("save", "cup", edits=2)[0] == 200
    again = Page(other.server)
    assert [item["label"] for item in again.project["objects"] if item not in again.others] == ["cup"]
    assert again.post("save", "bowl")[0] == 200 and one.post("save", "mug", edits=3)[0] == 409
    assert again.labels() == ["bowl"]


@pytest.mark.parametrize("change", [Path.unlink, lambda path: path.write_text(path.read_text() + "\n")])
def test_what_an_editor_changed_or_deleted_is_not_overwritten(opens: Open, change: Callable[[Path], Any]) -> None:
    page = Page(opens())
    assert page.post("save", "mug")[0] == 200
    change(page.path)
    there = page.path.is_file() and page.path.read_text()
    status, why = page.post("save", "bowl", edits=2)
    assert status == 409 and "is not saved" in why and there == (page.path.is_file() and page.path.read_text())
    assert Page(page.server).post("save", "bowl")[0] == 200 and page.labels() == ["bowl"]


def test_of_two_saves_at_one_moment_one_wins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "sync", lambda _: time.sleep(0.2))
    barrier, outcomes = Barrier(2), []

    def write(kept: Kept, value: str) -> None:
        barrier.wait()
        try:
            kept.write(value)
            outcomes.append(value)
        except OutdatedError:
            outcomes.append("refused")

    threads = [Thread(target=write, args=(Kept(tmp_path / "new/a.json"), value)) for value in ("one", "other")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (won,) = [value for value in outcomes if value != "refused"]
    assert len(outcomes) == 2 and json.loads((tmp_path / "new/a.json").read_text()) == won
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["a.json"], "no lock is left in the folder"


def test_an_older_tab_neither_writes_nor_ends_the_server(opens: Open) -> None:
    older = Page(opens())
    newer = Page(older.server)
    for command in ("save", "write", "close"):
        status, why = older.post(command)
        assert status == 409 and "another tab" in why
    assert not older.server.session.finished and not older.path.exists()
    assert newer.post("save")[0] == 200 and newer.post("close")[0] == 200 and older.server.session.finished


def test_a_save_that_was_overtaken_changes_nothing(opens: Open) -> None:
    page = Page(opens())
    assert page.post("save", "newer", edits=5)[0] == 200
    assert page.post("save", "older", edits=4)[0] == 200 and page.labels() == ["newer"]
    assert page.post("save", "again", edits=5)[0] == 200 and page.labels() == ["again"], "as after an error"
    assert Page(page.server).post("save", "next", edits=1)[0] == 200 and page.labels() == ["next"]


@pytest.mark.parametrize("busy", ["solve", "write"])
def test_a_save_waits_for_no_computation_and_is_not_overwritten_by_it(
    opens: Open, monkeypatch: pytest.MonkeyPatch, busy: str
) -> None:
    page, begun, go_on = Page(opens()), Event(), Event()
    module: Any = correcting if page.corrects else session
    name = ("paint_masks" if busy == "solve" else "correct_masks") if page.corrects else "finish_drawing"
    compute = getattr(module, name)

    def slowly(*given: Any) -> Any:
        begun.set()
        assert go_on.wait(20)
        return compute(*given)

    monkeypatch.setattr(module, name, slowly)
    statuses: list[int] = []
    thread = Thread(target=lambda: statuses.append(page.post(busy, "mug", edits=1)[0]))
    thread.start()
    assert begun.wait(20)
    assert page.post("save", "bowl", edits=2)[0] == 200 and page.labels() == ["bowl"] and not statuses
    go_on.set()
    thread.join()
    assert statuses == [200] and page.labels() == ["bowl"]


@pytest.mark.parametrize(("during", "wait"), [("correct_masks", 20), ("write_masks", 0.3)])
def test_what_is_saved_while_a_frame_gets_its_masks_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, during: str, wait: float
) -> None:
    folder = write_room(tmp_path / "frame", BOXES, ["cabinet", "box"])
    for name in ("masks.png", "annotations.json"):
        (folder / name).unlink()
    page = Page(serve(Correcting(folder, [], tmp_path / "results", "frame")))
    saved = Thread(target=lambda: page.post("save", "bowl", edits=2))

    def meanwhile(*given: Any) -> Any:
        saved.start()
        saved.join(wait)
        return step(*given)

    step = getattr(correcting, during)
    monkeypatch.setattr(correcting, during, meanwhile)
    assert page.post("write", "mug", edits=1) == (200, "")
    saved.join()
    written = json.loads((folder / "annotations.json").read_text())["objects"]
    again = Correcting(folder, [], tmp_path / "results", "frame").open_drawing()
    assert [item["label"] for item in written] == ["mug"] and again.objects[0].label == "bowl"
    page.server.shutdown()
    page.server.server_close()


def test_half_a_request_is_not_kept(opens: Open) -> None:
    page = Page(opens())
    page.post("save", "mug")
    before, body = page.path.read_bytes(), json.dumps(page.project).encode()
    with socket.create_connection(("127.0.0.1", page.server.server_port), timeout=20) as link:
        host = f"127.0.0.1:{page.server.server_port}"
        head = f"POST /{page.server.token}/save HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n"
        link.sendall(f"{head}X-Page: 1\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body[: len(body) // 2])
        link.shutdown(socket.SHUT_WR)
        assert link.makefile("rb").readline().split()[1] == b"400"
    assert page.path.read_bytes() == before and page.post("save", "bowl", edits=2)[0] == 200


def test_a_kill_in_the_middle_of_a_save_leaves_the_last_whole_state(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    Kept(path).write("whole")
    killed = (
        "import os, sys; from pathlib import Path; from roomkin.plugins.annotator.kept import Kept; "
        "from roomkin.stages.contracts import files; files.sync = lambda path: os.kill(os.getpid(), 9); "
        "Kept(Path(sys.argv[1])).write('half')"
    )
    assert subprocess.run([sys.executable, "-c", killed, str(path)], check=False).returncode == -9
    assert json.loads(path.read_text()) == "whole"
    Kept(path).write("next")  # the lock is gone with the process
    assert json.loads(path.read_text()) == "next"


@pytest.mark.parametrize("fails", [(files, "sync"), (files, "record")], ids=["before", "after"])
def test_an_error_of_the_disk_does_not_look_as_if_others_had_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: tuple[Any, str]
) -> None:
    def full(_: Path) -> None:
        raise OSError(errno.ENOSPC, "full")

    kept = Kept(tmp_path / "a.json")
    kept.write("first")
    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space left"):
        patch.setattr(*fails, full)
        kept.write("second")
    assert json.loads(kept.path.read_text()) in ("first", "second"), "whole"
    kept.write("third")
    assert json.loads(kept.path.read_text()) == "third"
