"""What carries an object: level tops under noise, pictures above furniture, what would be squeezed flat."""

from typing import Any

import numpy as np
import pytest

from roomkin.stages.contracts import Annotations
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import find_category, may_stand_on
from roomkin.stages.contracts.objects import USUAL_ERROR, SceneObject, Wall
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.clouds import find_carrying_heights, find_level, is_uppermost
from roomkin.stages.extraction.contact import DepthView, make_gap
from roomkin.stages.extraction.mounting import end_near, mount_objects, place_object
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.objects import MeasuredObject
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.clouds import minimum_box

KNOWN = known_categories()
LOOKING_ALONG_X = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5], [0, 0, 0, 1.0]])
WALL = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)


def level(cloud: np.ndarray) -> float | None:
    return find_level(cloud, minimum_box(cloud, 0.01), 2.0)


def surface(rng: np.random.Generator, count: int, height: float, low: tuple, high: tuple) -> np.ndarray:
    """Points (N, 3) of a level rectangle, a little off."""
    points = rng.uniform([*low, 0], [*high, 0], (count, 3))
    points[:, 2] = height + rng.normal(0, 0.004, count)
    return points


@pytest.mark.parametrize("tallest", [0.4, 0.2])  # the latter: all of one height
@pytest.mark.parametrize("covered", [0, 0.06, 0.2, 0.4])
@pytest.mark.parametrize("seed", range(5))
def test_a_desk_is_as_high_as_most_of_its_top(covered: float, seed: int, tallest: float) -> None:
    """Boxes of up to 40 cm stand on it, their fronts seen."""
    rng = np.random.default_rng(seed)
    parts = [
        surface(rng, 4000, 0.75, (-0.35, -0.7), (0.35, 0.7)),
        rng.uniform([-0.35, -0.7, 0], [-0.3, 0.7, 0.7], (600, 3)),
    ]
    for _ in range(round(covered * 20)):
        low, height = rng.uniform([-0.35, -0.7], [0.1, 0.45]), rng.uniform(0.05 if tallest > 0.2 else tallest, tallest)
        high = low + 0.22
        parts[0] = parts[0][~((parts[0][:, :2] > low) & (parts[0][:, :2] < high)).all(axis=1)]
        parts.append(surface(rng, 200, 0.75 + height, tuple(low), tuple(high)))
        parts.append(rng.uniform([low[0], low[1], 0.75], [low[0] + 0.01, high[1], 0.75 + height], (300, 3)))
    cloud = np.concatenate(parts)
    found = level(cloud)
    assert found == pytest.approx(0.75, abs=0.01)
    if covered:
        assert np.quantile(cloud[:, 2], 0.99) > 0.79  # what the quantile makes of it


def test_a_single_point_above_a_top_does_not_hide_it() -> None:
    heights = np.array([0.3, 0.75, 0.75, 0.75, 1.2])
    points = np.column_stack([np.zeros((5, 2)), heights])  # one cell of the plan
    upper = is_uppermost(points, UprightBox([0, 0, 0.6], [1, 1, 1.2], 0.0), 0.02)
    assert upper.tolist() == [False, True, True, True, True]


def test_a_chair_carries_at_its_seat_and_is_as_high_as_its_back() -> None:
    rng = np.random.default_rng(0)
    back = rng.uniform([0.45, 0, 0.45], [0.5, 0.5, 0.9], (1000, 3))
    found = level(np.concatenate([surface(rng, 3000, 0.45, (0, 0), (0.5, 0.5)), back]))
    assert found == pytest.approx(0.45, abs=0.01)
    assert find_carrying_heights(KNOWN["chair"], found, 0.9) == (found, 0.9)


def test_boards_of_a_shelf_are_no_top() -> None:
    assert find_carrying_heights(KNOWN["bookshelf"], 0.8, 1.8) == (1.8,)
    assert find_carrying_heights(KNOWN["sideboard"], 0.8, 1.8) == (0.8, 1.8)
    assert find_carrying_heights(None, None, 1.8) == (1.8,)


@pytest.mark.parametrize(
    ("bottom", "top"), [(0.52, 0.45), (0.85, 0.9), (0.67, 0.9)]
)  # a table's top over it: not on it
def test_a_carrier_ends_at_its_height_that_is_near(bottom: float, top: float) -> None:
    chair = UprightBox([2, 0, 0.45], [0.5, 0.5, 0.9], 0.0)
    assert end_near(chair, (0.45, 0.9), bottom, 0.12).top == pytest.approx(top)


@pytest.mark.parametrize(
    ("label", "carries"),
    [("Chest of drawers", "top"), ("coffee-table", "top"), ("kitchen counter", "top"), ("shelves", "boards"),
     ("table lamp", ""), ("desk chair", "seat"), ("settee", "seat"), ("area rug", "floor")],
)  # fmt: skip
def test_the_category_that_a_label_means_or_is_like_says_where_it_carries(label: str, carries: str) -> None:
    found = find_category(label, KNOWN, like=True)
    assert found is not None and found.carries == carries


@pytest.mark.parametrize(
    ("upper", "lower", "may"),
    [("table", "chair", False), ("chair", "rug", True), ("mug", "table", True), ("mug", "floor_lamp", False),
     ("can", "bowl", True), ("bed", None, False), (None, "chair", True), (None, "picture", False), (None, None, True)],
)  # fmt: skip
def test_categories_say_what_stands_on_what(upper: str | None, lower: str | None, may: bool) -> None:
    assert may_stand_on(KNOWN.get(upper or ""), KNOWN.get(lower or "")) is may


def test_a_front_has_no_level() -> None:
    assert level(np.random.default_rng(0).uniform(0, 1, (4000, 3))) is None
    assert level(np.random.default_rng(0).uniform(0, [1, 1, 0.01], (4000, 3))) is None


@pytest.mark.parametrize(("hidden_up_to", "mounting"), [(1.425, 1), (1.6, 3)])
def test_a_picture_above_furniture_hangs(hidden_up_to: float, mounting: int) -> None:
    """A picture at the wall x = 4, 1.5 to 1.9 m high; something 2 m away hides what is below, its lower edge or not."""
    v, u = np.mgrid[:240, :320]
    rise = -(v - 120) / 200.0  # of the rays, per metre
    depth = np.where(1.5 + 2 * rise <= hidden_up_to, 2.0, 4.0).astype(np.float32)
    view = DepthView(depth, np.array([[200.0, 0, 160], [0, 200.0, 120], [0, 0, 1]]), LOOKING_ALONG_X, USUAL_ERROR)
    own = (np.abs(u - 160) < 15) & (1.5 + 4 * rise > 1.5) & (1.5 + 4 * rise < 1.9) & (depth == 4)
    picture = UprightBox([3.97, 0, 1.7], [0.05, 0.6, 0.4], 0.0)
    assert place_object(picture, {}, [], [WALL], view, own).mounting.type == mounting


@pytest.mark.parametrize(("seen", "mounting"), [(1.5, 1), (1.45, 3)])
def test_a_picture_just_above_a_lamp_far_away_hangs(seen: float, mounting: int) -> None:
    """At 8 m, a lamp 1.42 m high before it: 8 cm are four pixels of wall between the two; 3 cm are none that counts."""
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-8.0, points=100)
    v, u = np.mgrid[:240, :320]
    height, side = 1.5 - (v - 120) / 400.0 * 8, (u - 160) / 400.0 * 8
    own = (np.abs(side) < 0.3) & (height > seen) & (height < 1.9)
    lamp = (np.abs(side) < 0.2) & (height < 1.42)
    view = DepthView(
        np.where(lamp, 7.7, 8.0).astype(np.float32),
        np.array([[400.0, 0, 160], [0, 400.0, 120], [0, 0, 1]]),
        LOOKING_ALONG_X,
        USUAL_ERROR,
    )
    picture = UprightBox([7.95, 0, (seen + 1.9) / 2], [0.3, 0.6, 1.9 - seen], 0.0)
    stand = UprightBox([7.8, 0, 0.71], [0.4, 0.4, 1.42], 0.0)
    placed = place_object(picture, {"stand": stand}, [stand], [wall], view, own)
    assert placed.mounting.type == mounting
    assert placed.box.bottom == pytest.approx(seen if mounting == 1 else 1.42)


@pytest.mark.parametrize(
    (
        "distance",
        "height",
        "left",
    ),  # of a box, a plate, a box above it all the same; nearer depth errs less: it is in it
    [(3.5, 0.09, 0.01), (3.5, 0.03, 0.01), (3.5, 0.25, 0.15), (2.0, 0.09, 0.09)],
)
def test_what_is_squeezed_flat_is_told(distance: float, height: float, left: float) -> None:
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), LOOKING_ALONG_X, USUAL_ERROR)
    table = UprightBox([distance, 0, 0.3], [1, 1, 0.6], 0.0)  # found 10 cm too high
    seen = UprightBox([distance, 0, 0.5 + height / 2], [0.2, 0.2, height], 0.0)
    placed = place_object(seen, {"table": table}, [table], [], empty, np.zeros((9, 9), bool))
    assert placed.box.size[2] == pytest.approx(left)
    assert placed.collapsed == (left == 0.01 and height == 0.09)


def held_by(box: UprightBox, carrier: UprightBox, walls: list[Wall], focal: float = 30.0, **said: Any) -> str:
    lens = np.array([[focal, 0, 45], [0, focal, 45], [0, 0, 1]])
    empty = DepthView(np.full((90, 90), 9.0, np.float32), lens, LOOKING_ALONG_X, USUAL_ERROR)
    own = np.zeros((90, 90), bool)
    placed = place_object(box, {"carrier": carrier}, [carrier], walls, empty, own, **said)
    return placed.support


@pytest.mark.parametrize(
    ("y", "bottom", "said", "support"),
    [
        (0.45, 0.61, {}, "carrier"),
        (0.55, 0.61, {}, "carrier"),  # a third over its edge: depth of one of them errs
        (0.75, 0.61, {"category": KNOWN["mug"]}, "unnamed"),  # in the air: no cup is a column
        (0.75, 0.61, {"category": KNOWN["vase"]}, "floor"),
        (0.55, 0.85, {}, "floor"),
        (0.75, 0.61, {}, "floor"),
    ],
)
def test_what_would_become_a_column_stands_on_what_it_is_beside(
    y: float, bottom: float, said: dict, support: str
) -> None:
    table, cup = UprightBox([2, 0, 0.3], [1, 1, 0.6], 0.0), UprightBox([2, y, bottom + 0.05], [0.1, 0.1, 0.1], 0.0)
    assert held_by(cup, table, [], **said) == support


def test_what_may_hang_and_never_stands_on_the_floor_hangs_though_its_lower_edge_is_not_seen() -> None:
    clock, cupboard = UprightBox([3.97, 0, 1.7], [0.05, 0.3, 0.3], 0.0), UprightBox([3.7, 2, 0.5], [0.5, 0.5, 1], 0.0)
    assert held_by(clock, cupboard, [WALL], category=KNOWN["clock"]) == "wall"
    assert held_by(clock, cupboard, [], category=KNOWN["clock"]) == "unnamed"


def test_a_lamp_whose_foot_was_lost_stands_on_the_nightstand_below_it() -> None:
    shade, chest = UprightBox([3.8, 0, 1.5], [0.3, 0.3, 0.4], 0.0), UprightBox([3.75, 0, 0.6], [0.5, 0.5, 1.2], 0.0)
    assert held_by(shade, chest, [WALL], focal=200, category=KNOWN["table_lamp"]) == "carrier"
    assert held_by(shade, chest, [WALL], focal=200) == "wall"


@pytest.mark.parametrize(("label", "bottom"), [("table", 0.0), ("thing", 0.45)])
def test_a_table_over_a_chair_stands_on_the_floor(label: str, bottom: float) -> None:
    """Of the table only its top is seen, just above the chair's seat."""
    boxes = {
        "chair": UprightBox([2, 0, 0.225], [0.5, 0.5, 0.45], 0.0),
        label: UprightBox([2, 0, 0.6], [0.6, 0.6, 0.28], 0.0),
    }
    found = [
        MeasuredObject(SceneObject(id=name, label=name, mask=number), Annotation(mask=number, label=name),
                       np.zeros((90, 90), bool), np.zeros((0, 3)), box, (box.top,), find_category(name, KNOWN))
        for number, (name, box) in enumerate(boxes.items(), 1)
    ]  # fmt: skip
    lens = np.array([[30.0, 0, 45], [0, 30.0, 45], [0, 0, 1]])
    view = DepthView(np.full((90, 90), 9.0, np.float32), lens, LOOKING_ALONG_X, USUAL_ERROR)
    pixels, stated = np.zeros((90, 90, 3), np.uint8), Annotations(objects=[one.stated for one in found])
    image = AnnotatedImage(pixels, view.depth, np.zeros((90, 90), np.uint16), lens, stated)
    placed = {one.object.id: one.object for one in mount_objects("room", found, image, [], {}, view)}[label]
    assert placed.box is not None and placed.measured_support == ("floor" if bottom == 0 else "chair")
    assert placed.box.center[2] - placed.box.size[2] / 2 == pytest.approx(bottom)


def test_a_cabinet_on_the_wall_beside_a_tall_fridge_hangs() -> None:
    fridge, cabinet = (
        UprightBox([3.7, 0, 0.73], [0.6, 0.6, 1.46], 0.0),
        UprightBox([3.8, 0.55, 1.7], [0.4, 0.6, 0.6], 0.0),
    )
    assert held_by(cabinet, fridge, [WALL]) == "wall"


@pytest.mark.parametrize(("bottom", "support"), [(0.62, "table"), (1.0, "unnamed")])
def test_a_told_box_above_all_that_was_named_stands_on_something_else(bottom: float, support: str) -> None:
    empty = DepthView(np.full((9, 9), 9.0, np.float32), np.diag([9.0, 9.0, 1.0]), LOOKING_ALONG_X, USUAL_ERROR)
    table = UprightBox([3, 0, 0.3], [1, 1, 0.6], 0.0)
    told = UprightBox([3, 0, bottom + 0.1], [0.2, 0.2, 0.2], 0.0)
    placed = place_object(told, {"table": table}, [table], [], empty, np.zeros((9, 9), bool), True)
    assert placed.support == support and placed.box.bottom == pytest.approx(bottom)


def test_the_gap_behind_a_box_that_is_a_little_turned_is_as_wide_as_its_rear() -> None:
    gap = make_gap(UprightBox([3, 0, 0.5], [0.6, 0.8, 1.0], 0.2), WALL)
    assert gap.along[1] - gap.along[0] == pytest.approx(0.8 * np.cos(0.2), abs=1e-6)
