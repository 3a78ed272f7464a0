"""Draws a room of known truth into the page of `annotate`, as a person would: by clicks near the right pixels."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.annotator.server import PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.stages.contracts import Annotations, Camera, Truth, read_json
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.geometry.boxes import UprightBox, corners
from roomkin.stages.geometry.frames import invert_transform, project, transform_points, wrap_angle


@dataclass
class TrueRoom:
    """A folder with camera.json, truth.json and annotations.json."""

    folder: Path

    def __post_init__(self) -> None:
        self.intrinsics = read_json(Camera, self.folder / "camera.json").intrinsics
        self.truth = read_json(Truth, self.folder / "truth.json")
        said = read_json(Annotations, self.folder / "annotations.json")
        self.said = {item.mask: item for item in said.objects}
        self.world_from_camera = np.array(self.truth.world_from_camera)
        self.eye = self.world_from_camera[:3, 3]

    def pixels(self, points: Any) -> NDArray[np.float64]:
        return project(transform_points(invert_transform(self.world_from_camera), points), self.intrinsics)

    def front(self, item: TrueObject) -> tuple[NDArray[np.float64], int, int]:
        """Corners of an object, and the lower ones, left and right, of the side that faces the camera most."""
        points = corners(UprightBox(item.position, item.size, item.yaw))
        middles = [(points[i] + points[(i + 1) % 4]) / 2 - item.position for i in range(4)]
        to_eye = (self.eye - item.position)[:2]
        facing = [middle[:2] @ to_eye / np.linalg.norm(middle[:2]) for middle in middles]
        i = int(np.argmax(facing))
        pair = sorted((i, (i + 1) % 4), key=lambda k: self.pixels(points[k])[0])
        return points, pair[0], pair[1]

    def rear(self, item: TrueObject) -> NDArray[np.float64]:
        """The upper rear corner that is farthest from the front in the picture."""
        points, left, right = self.front(item)
        behind = {
            k: min((left, right), key=lambda j: float(np.linalg.norm(points[k] - points[j])))
            for k in range(4)
            if k not in (left, right)
        }
        shift = {k: np.linalg.norm(np.subtract(*self.pixels(points[[k + 4, j + 4]]))) for k, j in behind.items()}
        return np.asarray(points[max(shift, key=lambda k: float(shift[k])) + 4])


class Hand:
    """Clicks into the picture on the page, a pixel or so beside the point."""

    def __init__(self, page: Any, room: TrueRoom, noise: float) -> None:
        self.page, self.room, self.noise = page, room, noise
        self.rng = np.random.default_rng(0)
        self.place = page.locator("#view").evaluate("e => { const m = e.getScreenCTM(); return [m.a, m.d, m.e, m.f]; }")

    def at(self, pixel: Any) -> tuple[float, float]:
        """Where on the page a pixel is."""
        a, d, e, f = self.place
        return pixel[0] * a + e, pixel[1] * d + f

    def click(self, point: Any) -> None:
        u, v = self.room.pixels(point) + self.rng.normal(0, self.noise, 2)
        x, y = self.at((u, v))
        self.page.mouse.move(x, y)
        self.page.mouse.click(x, y)

    def key(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def fill(self, name: str, value: object) -> None:
        self.page.get_by_label(name, exact=True).fill(str(value))
        self.key("Enter")

    def known_height(self, item: TrueObject) -> None:
        """The height of one object is the known length."""
        points, left, _ = self.room.front(item)
        self.key("m")
        self.click(points[left])
        self.click(points[left + 4])
        self.fill("Metres", item.size[2])

    def wall(self, a: Any, b: Any) -> None:
        self.key("w")
        self.click(a)
        self.click(b)

    def object(self, item: TrueObject, on: str) -> None:
        """One box; the page finds out itself what it stands on, unless `on` says so."""
        said = self.room.said[item.mask]
        points, left, right = self.room.front(item)
        before = self.page.locator("#objects button").count()
        self.key("b")
        self.page.locator("#next-on").select_option(on)
        self.page.locator("#view").focus()
        if item.support == "wall":
            self.click(points[left])
            self.click(points[right + 4])
        else:
            self.click(points[left])
            free = abs(wrap_angle(item.yaw, np.pi / 2)) > np.deg2rad(1)
            if free:
                self.page.keyboard.down("Shift")
            self.click(points[right])
            if free:
                self.page.keyboard.up("Shift")
            self.click((points[left + 4] + points[right + 4]) / 2)
        self.click(self.room.rear(item))
        drawn = f"document.querySelectorAll('#objects button').length === {before + 1}"
        self.page.wait_for_function(f"() => {drawn} && document.activeElement.id === 'label'")
        self.fill("What it is", said.label)
        for name, count in (("Doors", said.doors), ("Drawers", said.drawers)):
            if count:
                self.fill(name, count)


def wait_for(true: Callable[[], bool], page: Any = None) -> None:
    """Wait for a state of files, of the server, or of what a page sends: its events are heard meanwhile."""
    until = time.monotonic() + 20
    while not true():
        assert time.monotonic() < until
        page.wait_for_timeout(20) if page else time.sleep(0.02)


def serve(session: Session, other: Callable[[], Any] | None = None) -> PageServer:
    """A server in a thread of its own; `shutdown` ends it."""
    server = PageServer(session, other=other)
    Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()
    return server


@contextmanager
def watched(browser: Any, session: Any, ready: str, other: Callable[[], Any] | None = None) -> Iterator[Any]:
    """The page of a session once `ready` is there; nothing may be complained of."""
    server = serve(session, other)
    page = browser.new_page(viewport={"width": 1400, "height": 900})
    page.set_default_timeout(20_000)
    complaints: list[str] = []
    page.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(server.address)
    page.wait_for_selector(ready)
    yield page
    page.close()
    server.shutdown()
    server.server_close()
    assert not complaints, complaints
