"""The story of an object on the report page: pictures from mask and cloud, facts, rivals, doubts."""

import re
from html import unescape
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.report.album import THUMBNAIL, Album, SnapshotShards, views_of
from roomkin.plugins.report.doubts import group_doubts, measure_side
from roomkin.plugins.report.page.objects import Match, RoomResults, cloud_picture, match
from roomkin.plugins.report.report import WORDS
from roomkin.stages.contracts.cousins import Candidate, CategoryMatch, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import MEND, Doubt, DoubtKind
from roomkin.stages.contracts.generated import GeneratedScene, PlacedObject
from roomkin.stages.contracts.objects import Box, Mounting, Objects, SceneObject
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at
from roomkin.stages.tables.text import environment

WIDTH, HEIGHT = 120, 90
VIEW = Orientation(yaw=0.5, distance=1.0)


def thing(**changes: Any) -> SceneObject:
    fields: dict[str, Any] = {
        "id": "desk_1", "label": "desk", "mask": 1, "points": 900, "pixels": (20, 30, 60, 80),
        "box": Box(center=(3.0, 0.0, 0.4), size=(0.6, 1.2, 0.8), yaw=0.0),
        "mounting": Mounting(type=2),
    }  # fmt: skip
    return SceneObject(**(fields | changes))


def evidence(item: SceneObject, **changes: Any) -> RoomResults:
    objects = Objects(
        scene="t", width=WIDTH, height=HEIGHT, intrinsics=intrinsics_from_fov(WIDTH, HEIGHT, 0.9).tolist(),
        floor_from_camera=look_at([0, 0, 1.4], [3, 0, 0.4]).tolist(), walls=[], objects=[item],
    )  # fmt: skip
    fields: dict[str, Any] = {"objects": objects, "rgb": None, "masks": None, "clouds": {}, "placed": {}}
    return RoomResults(**(fields | changes))


def matched(distances: tuple[float, ...] = (1.0, 2.0, 3.0), category: str = "desk", **changes: Any) -> ObjectCousins:
    names = [f"desk_{number:02d}" for number in range(len(distances))]
    fields: dict[str, Any] = {
        "id": "desk_1", "label": "desk", "decided_by": "distance", "orientation_decided_by": "geometry",
        "categories": [CategoryMatch(category="desk", distance=0.0), CategoryMatch(category="table", distance=0.4)],
        "by_distance": [
            Candidate(asset=name, category="desk", distance=distance, parts={"patches": distance}, votes=7)
            for name, distance in zip(names, distances, strict=True)
        ],
        "cousins": [
            Cousin(rank=rank, asset=names[rank - 1], category=category, distance=distances[rank - 1], votes=7,
                   orientation=VIEW, orientations=[VIEW]) for rank in (1, 2)
        ],
    }  # fmt: skip
    return ObjectCousins(**(fields | changes))


def told(entry: ObjectCousins, item: SceneObject, **changes: Any) -> Match:
    return match(entry, item, evidence(item, **changes), Album(400, 80), SnapshotShards([]))


def facts(made: Match) -> dict[str, str]:
    """What the page says of an object."""
    page: Any = environment("roomkin.plugins.report").get_template("page/matches.html.jinja").make_module(WORDS)
    text = unescape(page.matches({"matches": [made], "choose": lambda _: ""}))
    return dict(re.findall(r"<dt>(.*?)</dt>\s*<dd>\s*(.*?)\s*</dd>", text))


def test_a_size_says_whether_it_is_measured_or_placed() -> None:
    page: Any = environment("roomkin.plugins.report").get_template("page/matches.html.jinja").make_module(WORDS)
    said = page.about(thing(), placed())
    assert re.search(r"\d+ cm high as measured in the picture, 120 wide × 60 deep × 80 cm high as placed$", said), said
    assert "placed" not in page.about(thing(), None)


def placed(**changes: Any) -> PlacedObject:
    fields = {"id": "desk_1", "label": "desk", "asset": "desk_00", "category": "desk", "size": (0.6, 1.2, 0.8)}
    return PlacedObject(**(fields | changes))


UNKNOWN = Doubt(cause="name", what="the word 'drill' is not known")
OTHERWISE = "was said to have 2 doors and 1 drawer, the model has 2 doors and no drawer; no fridge has that"


class Views:
    """Snapshots that know which views are asked for."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, float | None]] = []

    def picture(self, asset: str, yaw: float | None = None) -> None:
        self.asked.append((asset, yaw))


def test_it_tells_what_was_seen_compared_chosen_and_placed() -> None:
    made = told(matched(), thing(), placed={"desk_1": placed(yaw=np.pi / 2, support="rug_1", place_spread=0.042)})
    said = facts(made)
    assert said["place"] == "50 % sure to be right to 5 cm"
    assert said["mounting"] == "stands free, by geometry" and "900 points" in said["seen"]
    assert said["categories, by distance of the label"] == "desk 0.00, table 0.40"
    assert said["model chosen by"] == "distance"
    assert said["orientation chosen by"] == "geometry, turned by 29° in the camera's view"
    assert said["as placed"] == "desk 00 on rug_1, 120 wide × 60 deep × 80 cm high, turned by 90°"
    assert [rival.asset for rival, _ in made.rivals] == ["desk_00", "desk_01", "desk_02"]
    assert "stands" not in said and made.doubts == [] and made.pictures == []
    assert facts(told(matched(), thing(support="floor")))["stands"] == "on the floor, set by a person"


def test_cousins_are_shown_as_they_stand_else_as_matching_turned_them() -> None:
    """Generation lays rears into walls, whatever the picture says; ranks without a scene are drawn as matched."""
    scene = GeneratedScene(
        **evidence(thing()).objects.model_dump(include={"width", "height", "intrinsics", "floor_from_camera", "walls"}),
        scene="t", variant="default", rank=1, objects=[placed(position=(3.0, 0.0, 0.4), yaw=np.pi)],
    )  # fmt: skip
    snapshots: Any = Views()
    views = {"desk_1": views_of([scene], "desk_1")}
    match(matched(), thing(), evidence(thing(), views=views), Album(400, 80), snapshots)
    assert snapshots.asked[:2] == [("desk_00", pytest.approx(0.0)), ("desk_01", VIEW.yaw)]
    assert facts(told(matched(), thing(front=np.pi)))["orientation chosen by"].startswith("the input, turned by ")


@pytest.mark.parametrize(
    ("decided_by", "scores", "measure", "numbers"),
    [
        ("distance", (None, None), "distance of features: less is better", ["1.00", "2.00"]),
        ("votes", (None, None), "votes: more is better", ["7", "7"]),
        ("geometry", (1.5, 1.25), "fit by geometry: more is better", ["1.50", "1.25"]),
        ("geometry", (1.25, 1.5), "fit by geometry: more is better; alike objects are ordered by its mean",
         ["1.25", "1.50"]),
        ("geometry", (-0.25, -0.5), "no model fits, so no numbers: by name, doors and drawers, size and place",
         ["", ""]),
        ("vlm", (None, None), "", ["", ""]),
    ],
)  # fmt: skip
def test_cousins_have_the_number_that_put_them_in_their_order(
    decided_by: str, scores: tuple[float | None, float | None], measure: str, numbers: list[str]
) -> None:
    entry = matched(decided_by=decided_by)
    for cousin, score in zip(entry.cousins, scores, strict=True):
        cousin.score, cousin.terms = score, {"outline": 0.5, "priors": abs(min(score or 1.0, 0.0))}
    made = told(entry, thing())
    assert (made.measure, [number for _, number, _ in made.cousins]) == (measure, numbers)


@pytest.mark.parametrize(
    ("entry", "item", "there", "cause", "words"),
    [
        ({}, {"points": 40}, {}, "size", "only 40 points"),
        ({}, {"pixels": (0, 30, 60, 80)}, {}, "size", "border"),
        ({}, {"pixels": (20, 30, 60, HEIGHT)}, {}, "size", "border"),
        ({"doubts": [UNKNOWN]}, {}, {}, "name", "'drill' is not known"),
        ({}, {"note": "no wall is found in mask 3"}, {}, "mounting", "mask 3: mounting by geometry"),
        ({}, {"measured_mounting": Mounting(type=1)}, {}, "mounting", "finds another mounting: hangs on a wall"),
        ({}, {}, {"moved": 0.3}, "place", "pushed 30 cm"),
        ({}, {}, {"settled_shift": 0.04}, "place", "moved 4.0 cm when physics ran"),
        ({}, {}, {"doubts": [Doubt(cause="affordance", what=OTHERWISE)]}, "affordance", "2 doors and 1 drawer"),
    ],
)
def test_doubts(entry: dict[str, Any], item: dict[str, Any], there: dict[str, Any], cause: str, words: str) -> None:
    """What may be wrong and can be mended: each says what helps."""
    made = told(matched(**entry), thing(**item), placed={"desk_1": placed(**there)})
    (doubt,) = made.doubts
    assert doubt.cause == cause and words in doubt.what and made.notes == []
    assert str(doubt) == f"{doubt.what}: {MEND[doubt.cause]}"


@pytest.mark.parametrize(
    ("entry", "there", "words"),
    [
        ({"distances": (1.0, 1.04, 3.0)}, {}, "as near: desk 01"),
        ({"note": "models in one order with desk_2, which is alike"}, {}, "which is alike"),
        ({}, {"size": (1.2, 1.2, 0.8)}, "another depth or width"),
    ],
)
def test_what_nobody_needs_to_act_on_is_a_note(entry: dict[str, Any], there: dict[str, Any], words: str) -> None:
    made = told(matched(**entry), thing(), placed={"desk_1": placed(**there)})
    assert made.doubts == [] and len(made.notes) == 1 and words in made.notes[0]


@pytest.mark.parametrize(
    ("entry", "item", "there"),
    [
        ({}, {"points": 40, "pixels": (0, 30, 60, 80), "told": ["size"]}, {"size": (1.2, 1.2, 0.8)}),
        ({}, {"measured_mounting": Mounting(type=1), "told": ["mounting"]}, {}),
        ({"distances": (1.0, 1.04, 3.0)}, {}, {"chosen": True}),
    ],
)
def test_what_a_person_says_is_not_doubted(entry: dict[str, Any], item: dict[str, Any], there: dict[str, Any]) -> None:
    made = told(matched(**entry), thing(**item), placed={"desk_1": placed(**there)})
    assert made.doubts == [] and made.notes == []


def test_the_likeliest_come_first_and_those_of_one_cause_together() -> None:
    behind = Doubt(cause="place", what="behind", chance=0.8)
    first = placed(doubts=[behind, DoubtKind.OPENINGS.of(what=OTHERWISE)])
    made = told(matched(), thing(pixels=(0, 30, 60, 80), points=40), placed={"desk_1": first})
    assert [doubt.cause for doubt in made.doubts] == ["affordance", "place", "size", "size"]
    found = [("desk_1", doubt) for doubt in made.doubts] + [("bowl_1", made.doubts[3])]
    assert [(group.cause, [about for about, _ in group.items]) for group in group_doubts(found)] == [
        ("affordance", ["desk_1"]), ("place", ["desk_1"]), ("size", ["desk_1", "bowl_1"]),
    ]  # fmt: skip
    assert "; " in group_doubts(found)[2].items[0][1]


def test_the_size_of_a_thing_is_its_largest_side_as_placed_else_as_measured() -> None:
    assert measure_side(thing(), placed(size=(0.5, 2.0, 1.0))) == pytest.approx(2.0)
    assert measure_side(thing(), placed(status="failed", reason="-")) == pytest.approx(1.2 * 0.8)
    assert measure_side(thing(box=None, status="failed", reason="-"), None) == 1.0, "nobody knows it"


def test_a_box_that_is_turned_by_a_quarter_is_the_same_box() -> None:
    assert told(matched(), thing(), placed={"desk_1": placed(size=(1.2, 0.6, 0.8))}).doubts == []


@pytest.mark.parametrize("yaw", [0.0, 0.7, -0.6])
def test_a_cloud_is_drawn_as_the_camera_sees_it(yaw: float) -> None:
    """What is left and high for the camera is left and high in the picture, however the box's axes are called."""
    item = thing(box=Box(center=(3.0, 0.0, 0.4), size=(1.0, 1.0, 0.8), yaw=yaw))
    cloud = np.array([[3.0, 0.3, 0.7]], dtype=np.float32)  # left of the middle (y is left), and above it
    front = np.asarray(cloud_picture(cloud, item, evidence(item), (1, 2)))
    dark = np.argwhere((front == 110).all(axis=2))
    assert len(dark) == 1 and (dark < THUMBNAIL / 2).all()
    far = np.array([[3.3, 0.0, 0.4]], dtype=np.float32)  # away from the camera: up, seen from above
    above = np.asarray(cloud_picture(far, item, evidence(item), (1, 0)))
    assert np.argwhere((above == 110).all(axis=2))[:, 0].max() < THUMBNAIL / 2


def test_pictures_need_no_more_than_the_run_has() -> None:
    item = thing()
    cloud = np.array([[3.0, 0.3, 0.7]], dtype=np.float32)
    rgb, masks = np.full((HEIGHT, WIDTH, 3), 9, np.uint8), np.ones((HEIGHT, WIDTH), np.uint16)
    captions = [caption for _, caption in told(matched(), item, clouds={"desk_1": cloud}).pictures]
    assert captions == ["cloud from the front", "cloud from above"]
    both = told(matched(), item, rgb=rgb, masks=masks, clouds={"desk_1": cloud}).pictures
    assert [caption for _, caption in both] == ["mask", *captions]
    assert all(picture.source.startswith("data:image/webp") and picture.width <= THUMBNAIL for picture, _ in both)
