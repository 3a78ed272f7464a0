"""A submission against the truth: a row per thing that was asked for."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from roomkin.plugins.scorecard.measures import (
    FACING,
    MAX_BEHIND,
    PLACE,
    YAW,
    are_handles_right,
    is_sensible,
    is_size_right,
    knows_hinges,
    measure_overreach,
    measure_turn,
    size_errors,
)
from roomkin.plugins.scorecard.placing import PlacedRoom, place_room
from roomkin.plugins.scorecard.standing import (
    cut_solids,
    fill_solid,
    find_inside,
    find_standing,
    is_carrier_right,
    list_supports,
    measure_depths,
)
from roomkin.plugins.scorecard.truth import Cells, PictureTruth, RoomScene, Submission, TrueThing, read_truth
from roomkin.stages.geometry.boxes import oriented_iou


@dataclass(frozen=True)
class ThingRow:
    """A thing that was asked for. None: not asked of it, or the submission has no such thing.

    status: ok, missed, or unread (its room could not be read). shaped: `clear` and `stands` are about its mesh.
    """

    rooms: str
    picture: str
    number: int
    label: str
    kind: str
    model: str
    seen: float
    cut: bool
    status: str
    placed: bool = False
    name: str = ""
    sensible: bool = False
    size: bool = False
    place: bool = False
    yaw: bool | None = None
    facing: bool | None = None
    carrier: bool | None = None
    clear: bool = False
    stands: bool = False
    opens: bool | None = None
    handle: bool | None = None
    shaped: bool = False
    shape: float | None = None
    iou: float | None = None
    off_depth_cm: float | None = None
    off_width_cm: float | None = None
    off_height_cm: float | None = None
    off_place_cm: float | None = None
    yaw_degrees: float | None = None


@dataclass(frozen=True)
class RoomRow:
    """A room: its things, those submitted that stand for none, and why it could not be read."""

    picture: str
    asked: int
    placed: int
    extra: int
    scale: float | None
    unread: str = ""


def score_submission(
    submission: Submission, folders: Sequence[Path], shapes: dict[str, Cells]
) -> tuple[list[ThingRow], list[RoomRow]]:
    """Rows of things and of rooms; `shapes`: what is filled of the true models' boxes, by model."""
    things, rooms = list[ThingRow](), list[RoomRow]()
    for folder in folders:
        truth = read_truth(folder / "truth.json")
        asked = truth.list_asked("drawn masks" in submission.about.given)
        scene = submission.rooms.get(truth.name)
        if scene is None:
            status = "unread" if truth.name in submission.unread else "missed"
            things += [make_missing(truth, thing, status, asked) for thing in asked]
            rooms.append(RoomRow(truth.name, len(asked), 0, 0, None, submission.unread.get(truth.name, "")))
            continue
        placed = place_room(scene.room, truth, asked)
        things += score_room(truth, asked, scene, placed, shapes)
        extra = len(scene.room.things) - len(placed.pairs)
        rooms.append(RoomRow(truth.name, len(asked), len(placed.pairs), extra, round(placed.scale, 3)))
    return things, rooms


def make_missing(truth: PictureTruth, thing: TrueThing, status: str, asked: Sequence[TrueThing]) -> ThingRow:
    """The row of a thing that the submission lacks: wrong in all that is asked of it."""
    turns = None if thing.symmetry == "full" else False
    carried = is_carrier_right(thing, "", {}, [one.number for one in asked])
    opens, handle = (False if asked else None for asked in (knows_hinges(thing.opens), thing.handles))
    lacks: dict[str, Any] = {"yaw": turns, "facing": turns, "carrier": carried, "opens": opens, "handle": handle}
    return ThingRow(**_name(truth, thing), status=status, **lacks)


def _name(truth: PictureTruth, thing: TrueThing) -> dict[str, Any]:
    return {
        "rooms": truth.half, "picture": truth.name, "number": thing.number, "label": thing.label, "kind": thing.kind,
        "model": thing.model, "seen": thing.seen, "cut": thing.cut,
    }  # fmt: skip


def score_room(
    truth: PictureTruth, asked: Sequence[TrueThing], scene: RoomScene, placed: PlacedRoom, shapes: dict[str, Cells]
) -> Iterator[ThingRow]:
    """The rows of a room."""
    numbers = [thing.number for thing in asked]
    true_boxes = {placed.pairs[thing.number]: thing.box for thing in asked if thing.number in placed.pairs}
    supports = list_supports(scene.room.things, placed.boxes, truth.size)
    pieces = cut_solids(scene.solids, placed.boxes)
    overlaps, inside = find_inside(placed.boxes, true_boxes, measure_depths(placed.boxes, pieces), pieces)
    stands = find_standing(placed.boxes, supports, overlaps, pieces)
    for thing in asked:
        place = placed.pairs.get(thing.number)
        if place is None:
            yield make_missing(truth, thing, "missed", asked)
            continue
        given, box = scene.room.things[place], placed.boxes[place]
        x, y, z = (float(extent) for extent in box.size)
        errors = size_errors(thing, (x, y, z), box.yaw)
        off = float(np.linalg.norm(box.center - np.array(thing.position)))
        turn = measure_turn(thing, box.yaw)
        behind = measure_overreach(box, truth.size) > MAX_BEHIND
        solid, true_cells = scene.solids.get(place), shapes.get(thing.model)
        yield ThingRow(
            **_name(truth, thing),
            status="ok",
            placed=True,
            name=given.name,
            sensible=is_sensible(given.name, thing.kind),
            size=is_size_right(errors, thing.size),
            place=off <= PLACE,
            yaw=None if turn is None else turn <= YAW,
            facing=None if turn is None else turn <= np.deg2rad(FACING),
            carrier=is_carrier_right(thing, supports[place], placed.pairs, numbers),
            clear=not inside[place] and not behind,
            stands=bool(stands[place]),
            opens=sorted(given.opens) == sorted(thing.opens) if knows_hinges(thing.opens) else None,
            handle=are_handles_right(thing, placed.handles[place]),
            shaped=place in pieces,
            shape=None if solid is None or true_cells is None else measure_shape(fill_solid(solid), true_cells),
            iou=round(oriented_iou(box, thing.box), 3),
            off_depth_cm=round(100 * float(errors[0]), 1),
            off_width_cm=round(100 * float(errors[1]), 1),
            off_height_cm=round(100 * float(errors[2]), 1),
            off_place_cm=round(100 * off, 1),
            yaw_degrees=None if turn is None else round(float(np.rad2deg(turn)), 1),
        )


def measure_shape(ours: Cells, truth: Cells) -> float:
    """IoU of what is filled of two boxes (N, N, N), each stretched into the other."""
    return round(float((ours & truth).sum() / max(1, (ours | truth).sum())), 3)
