"""The folder of a picture: color, depth as a sensor gives it, two sets of masks with labels, and the truth."""

import json
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.open_rooms import crowd, packs, rooms, sensor, views
from benchmarks.open_rooms.render import photograph
from roomkin.plugins.scorecard.truth import PictureTruth, TrueThing, as_plain, read_truth
from roomkin.stages.contracts import write_atomically

MIN_PIXELS, MIN_SEEN = 250, 0.15  # of a thing that a person would outline and name
BY_HAND = ("exact", "drawn")  # masks whose values are the numbers of things
ALONE = "alone"  # of the picture without its depth
MASKS = (*BY_HAND, "unaided", "corrected", ALONE)  # corrected: the unaided ones, by clicks
NO_WALLS, NO_FLOOR, ONE_WALL = 0.25, 0.12, 0.35  # how often people name no walls, no floor, all walls as one


def read(folder: Path) -> PictureTruth:
    """The truth of the picture in a folder."""
    return read_truth(folder / "room.json")


def read_masks(folder: Path) -> NDArray[np.uint16]:
    """The exact masks (H, W) of the picture in a folder: numbers of things, walls, the floor."""
    return np.asarray(cv2.imread(str(folder / "exact.png"), cv2.IMREAD_UNCHANGED), np.uint16)


def folders(root: Path, half: str = "", kept: str = "pictures") -> list[Path]:
    """The pictures that are there, of one half or of all; kept in `pictures`, or in `learning`."""
    found = [folder / "room.json" for folder in sorted((root / kept).glob("*"))]
    halves = {path.parent: json.loads(path.read_text())["half"] for path in found if path.is_file()}
    return [folder for folder, which in halves.items() if half in ("", which)]


def make(root: Path, half: str, only: str, samples: int, learning: int = 0) -> None:
    """Render the pictures of a half that are not there yet; `learning`: as many others of each kind, to learn from."""
    models = packs.models(root / "packs", half)
    for name in rooms.names(half, learning):
        folder = root / ("learning" if learning else "pictures") / name
        if only in name and not (folder / "room.json").is_file():
            _make(root, folder, half, models, samples)
            print(folder, flush=True)


def _make(root: Path, folder: Path, half: str, models: list[packs.PackModel], samples: int) -> None:
    name = folder.name
    seed = zlib.crc32(name.encode())
    rng = np.random.default_rng(seed)
    kind = name.split("_")[-2]
    if kind == rooms.CROWD:
        room = rooms.furnish(kind, models + crowd.own_models(), views.top_of, rng, crowd.plan_crowd(rng))
    else:
        room = rooms.furnish(kind, models, views.top_of, rng)
    device = sensor.DEVICES[int(rng.integers(len(sensor.DEVICES)))]
    pose = views.look_at(room.eye, room.look, rng.normal(0, np.deg2rad(2.5)) if device.handheld else 0.0)
    caster = views.Caster(views.surfaces(room))
    seen, owner = views.cast_view(caster, pose, device.focal)
    things = _truth(room, caster, owner, pose, device.focal, rng)
    folder.mkdir(parents=True, exist_ok=True)
    depth = sensor.sense_depth(seen, device, rng)
    _write(folder / "depth.png", np.rint(1000 * depth).astype(np.uint16))
    for other in sensor.DEVICES:
        own = np.random.default_rng(zlib.crc32(f"{name}/{other.name}".encode()))  # what the others draw stays as it was
        measured = depth if other is device else sensor.sense_depth(seen, other, own)
        _write(folder / f"depth_{other.name}.png", np.rint(1000 * measured).astype(np.uint16))
    k = views.intrinsics(device.focal)
    camera = {
        "width": views.WIDTH, "height": views.HEIGHT_PX, "fx": k[0, 0], "fy": k[1, 1], "cx": k[0, 2], "cy": k[1, 2],
    }  # fmt: skip
    (folder / "intrinsics.json").write_text(json.dumps(camera, indent=1))
    joined = _write_masks(folder, owner, things, rng)
    truth = PictureTruth(
        name, half, kind, device.name, device.focal, room.size, pose.tolist(), things,
        {str(a): b for a, b in joined.items()},
    )  # fmt: skip
    picture = photograph(room, half, root / "packs", pose, device.focal, samples, seed)
    _write(folder / "rgb.png", np.array(picture)[..., ::-1])
    with write_atomically(folder / "room.json") as path:
        path.write_text(json.dumps(as_plain(truth), indent=1))


def _write(path: Path, pixels: NDArray[Any]) -> None:
    with write_atomically(path) as file:
        cv2.imwrite(str(file), pixels)


def _truth(
    room: rooms.OpenRoom,
    caster: views.Caster,
    owner: NDArray[np.uint16],
    pose: NDArray[np.float64],
    focal: float,
    rng: np.random.Generator,
) -> list[TrueThing]:
    numbers = {thing.name: str(number) for number, thing in enumerate(room.things, 1)}
    labels: dict[str, str] = {}
    found = []
    for number, thing in enumerate(room.things, 1):
        model = thing.model
        assert isinstance(model, packs.PackModel)
        mine = owner == number
        share = views.share_seen(caster, thing, number, owner, pose, focal) if mine.any() else 0.0
        names = packs.kinds()[model.kind].labels
        if model.id not in labels:
            labels[model.id] = str(rng.choice(names)) if names else ""
        x, y, z = thing.box.center
        found.append(
            TrueThing(
                number, thing.name, model.id, model.pack, model.kind, labels[model.id], model.doors, model.drawers,
                model.symmetry, (float(x), float(y), float(z)), model.size, thing.yaw,
                numbers.get(thing.support, thing.support), thing.wall, int(mine.sum()), round(share, 3),
                bool(mine[0].any() or mine[-1].any() or mine[:, 0].any() or mine[:, -1].any()),
                bool(names) and int(mine.sum()) >= MIN_PIXELS and share >= MIN_SEEN,
            )
        )  # fmt: skip
    return found


def _write_masks(
    folder: Path, owner: NDArray[np.uint16], things: list[TrueThing], rng: np.random.Generator
) -> dict[int, int]:
    """Exact and drawn masks, with the labels that people give."""
    named = {thing.number: thing.label for thing in things if thing.named}
    walls = [len(things) + 1 + k for k in range(len(rooms.WALLS))]
    floor = len(things) + len(rooms.WALLS) + 1
    known = np.where(np.isin(owner, [*named, *walls, floor]), owner, 0).astype(np.uint16)
    whole = {str(value): label for value, label in named.items()}
    whole |= {str(wall): "wall" for wall in walls} | {str(floor): "floor"}
    _write(folder / "exact.png", known)
    (folder / "exact.json").write_text(json.dumps(whole, indent=1))
    drawn, joined = sensor.draw_outlines(known, {*walls, floor}, rng)
    labels = dict(whole)
    if rng.random() < ONE_WALL:
        drawn[np.isin(drawn, walls)] = walls[0]
    if rng.random() < NO_WALLS:
        labels = {value: label for value, label in labels.items() if label != "wall"}
    if rng.random() < NO_FLOOR:
        labels = {value: label for value, label in labels.items() if label != "floor"}
    _write(folder / "drawn.png", np.where(np.isin(drawn, [int(v) for v in labels]), drawn, 0).astype(np.uint16))
    (folder / "drawn.json").write_text(
        json.dumps({v: t for v, t in labels.items() if (drawn == int(v)).any()}, indent=1)
    )
    return joined
