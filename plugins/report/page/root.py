"""What all of a scene rests on, for the top of its page: ground and walls, what was left out, what corrections lost."""

from dataclasses import dataclass
from pathlib import Path

from plugins.report.page.rooms import Reconstruction
from stages.contracts.corrections import CORRECTIONS, corrections_of
from stages.contracts.files import read_json
from stages.contracts.images import read_masks
from stages.contracts.objects import Objects
from stages.contracts.things import Ground, Thing, Things, read_things
from stages.geometry.masks import outline_mask

AS_HIGH = 0.02  # metres by which two heights of the camera are the same; chosen


@dataclass(frozen=True)
class LeftOut:
    """A thing that was found and is not placed.

    guess: what it may be. outlines: of its pixels, as points of SVG. at: where its name stands, the highest pixel.
    command: opens the page on which a click takes it.
    """

    mask: int
    guess: str
    why: str
    outlines: list[str]
    at: tuple[int, int]
    command: str


@dataclass(frozen=True)
class Root:
    """Sentences about ground, walls and things; what was left out; what could not be kept of corrections; pixels."""

    facts: list[str]
    left_out: list[LeftOut]
    lost: list[str]
    width: int
    height: int


def read_root(objects: Path | None, folder: Path, made: Reconstruction | None) -> Root | None:
    """The root of a scene; None: nothing was found in it.

    Args:
        objects: objects.json of the scene.
        folder: its input folder; things.json in it, if it is there, says what the ground was taken from.
        made: has the command that opens the page to correct the scene.
    """
    if objects is None:
        return None
    found, things = read_json(Objects, objects), read_things(folder)
    left_out = list_left_out(things, folder, made.correct if made else "") if things else []
    many = sum(item.status == "ok" for item in found.objects)
    facts = [describe_ground(found, things.ground if things else None), describe_walls(found)]
    facts.append(f"{many} {'thing was' if many == 1 else 'things were'} found, {len(left_out) or 'nothing'} left out.")
    return Root(facts, left_out, found.lost, found.width, found.height)


def describe_ground(found: Objects, ground: Ground | None) -> str:
    """How high the camera is, and what the ground was taken from."""
    height = found.floor_from_camera[2][3]
    text = f"The camera is {height:.2f} m above the ground"
    if ground is None:
        return f"{text}."
    source = f"{ground.taken_from} ({100 * ground.share:.1f} % of the picture)"
    if abs(ground.camera_height - height) <= AS_HIGH:
        return f"{text}, which was taken from {source}."
    return f"{text}; it is not {source}, which is {ground.camera_height:.2f} m below the camera."


def describe_walls(found: Objects) -> str:
    """How many walls there are, and how far away."""
    if not found.walls:
        return "No wall was found."
    nearest = min(abs(wall.offset) for wall in found.walls)  # the frame's origin is below the camera
    many = "1 wall was found" if len(found.walls) == 1 else f"{len(found.walls)} walls were found"
    return f"{many}, {'' if len(found.walls) == 1 else 'the nearest '}{nearest:.1f} m from the camera."


def list_left_out(things: Things, folder: Path, correct: str) -> list[LeftOut]:
    """What was left out and nobody has taken; `correct`: the command, up to an id, that opens the page."""
    path = folder / CORRECTIONS
    said = corrections_of((path,) if path.is_file() else (), "extraction").values()
    taken = {mask for item in said for mask in (item.mask, *item.joins)}
    masks = read_masks(folder / "masks.png")

    def show(item: Thing) -> LeftOut:
        curves = outline_mask(masks == item.mask)
        x, y = min((point for curve in curves for point in curve), key=lambda point: point[1])
        points = [" ".join(f"{u},{v}" for u, v in curve) for curve in curves]
        return LeftOut(item.mask, item.guess, item.left_out, points, (x, y), correct and f"{correct}drawn_{item.mask}")

    return [show(item) for item in things.left_out if item.mask not in taken and (masks == item.mask).any()]
