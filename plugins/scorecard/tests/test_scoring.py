"""What is right about a submission, and what is not: one room whose truth is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from roomkin.plugins.scorecard import carrying, naming, pairing, placing, scoring
from roomkin.plugins.scorecard.scoring import ThingRow
from roomkin.plugins.scorecard.submission import About, RoomScene, Submission, SubmittedRoom
from roomkin.plugins.scorecard.tests.rooms import CABINET, HEAD, MUG, POSE, TABLE, TRUTH, room, say
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import invert_transform, transform_points

RIGHT = ["placed", "sensible", "size", "place", "carrier", "clear", "stands"]


def score(document: dict[str, Any], cells: Any = None, shapes: Any = None) -> dict[str, ThingRow]:
    """Rows by label."""
    scene = RoomScene(SubmittedRoom.model_validate(document), cells or {})
    asked = TRUTH.list_asked(drawn=False)
    placed = placing.place_room(scene.room, TRUTH, asked)
    return {row.label: row for row in scoring.score_room(TRUTH, asked, scene, placed, shapes or {})}


def test_the_truth_is_right_in_everything_that_is_asked() -> None:
    rows = score(room(say(TABLE), say(MUG), say(CABINET)))
    assert len(rows) == 3  # not what has no name
    for row in rows.values():
        assert all(getattr(row, name) for name in RIGHT), row
        assert row.off_place_cm == 0 and row.iou == pytest.approx(1)
    assert rows["cupboard"].opens is True and rows["cup"].opens is None and rows["cup"].yaw is None


def test_what_is_missing_is_wrong_and_no_error() -> None:
    rows = score(room(say(MUG)))
    table = rows["dining table"]
    assert table.status == "missed" and not any(getattr(table, name) for name in RIGHT)
    assert table.yaw is table.facing is False and rows["cupboard"].opens is False
    assert rows["cup"].placed and rows["cup"].carrier is False  # nothing is under it
    assert score(room())["cup"].carrier is False


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        ({"name": "sofa"}, {"sensible"}),
        ({"size": [0.8, 1.55, 0.8]}, {"size"}),
        ({"center": [2.0, 2.06, 0.4]}, {"place"}),
        ({"yaw": 0.2 + 0.5}, {"yaw"}),
        ({"yaw": 0.2 + 0.9}, {"yaw", "facing", "size"}),  # nearer to a quarter turn
        ({"yaw": 0.2 + np.pi}, set()),  # its symmetry
        ({"center": [2.0, 2.0, 0.47]}, {"place", "carrier", "stands"}),
        ({"center": [2.0, 2.0, 0.3]}, {"place", "clear", "stands"}),
    ],
)
def test_a_fault_is_found_where_it_is(said: dict[str, Any], wrong: set[str]) -> None:
    row = score(room(say(TABLE, **said), say(CABINET)))["dining table"]
    assert {name for name in [*RIGHT, "yaw", "facing"] if not getattr(row, name)} == wrong


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        ({"center": [0.21, 1.0, 0.45]}, {"place"}),  # 9 cm in the wall
        ({"center": [0.15, 1.0, 0.45]}, {"place", "clear"}),
        ({"opens": ["right"]}, {"opens"}),
        ({"opens": []}, {"opens"}),
    ],
)
def test_a_fault_of_what_stands_at_a_wall_and_opens_is_found(said: dict[str, Any], wrong: set[str]) -> None:
    row = score(room(say(CABINET, **said)))["cupboard"]
    assert {name for name in [*RIGHT, "opens"] if not getattr(row, name)} == wrong


def test_the_camera_s_frame_says_the_same_as_the_floor_s() -> None:
    camera = invert_transform(POSE)
    things = [say(one, center=transform_points(camera, one.position).tolist()) for one in (TABLE, MUG, CABINET)]
    rows = score({"frame": "camera", "things": things})
    assert all(getattr(row, name) for row in rows.values() for name in [*RIGHT, "place"])
    assert rows["cupboard"].yaw_degrees == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("factor", [0.2, 3.0])
@pytest.mark.parametrize("numbered", [True, False])
def test_what_is_up_to_one_factor_is_scored_after_it(factor: float, numbered: bool) -> None:
    eye = POSE[:3, 3]
    things = [
        say(
            one,
            center=(eye + factor * (np.array(one.position) - eye)).tolist(),
            size=[factor * extent for extent in one.size],
            **({"number": one.number} if numbered else {}),
        )
        for one in (TABLE, MUG, CABINET)
    ]
    free = score(room(*things, scale="free"))
    assert all(row.place and row.size for row in free.values())
    assert not any(row.place for row in score(room(*things)).values())


def test_things_are_paired_by_number_or_by_place_and_never_by_name() -> None:
    boxes = [UprightBox((0, 0, 0), (1, 1, 1), 0), TABLE.box, UprightBox((2.0, 2.1, 0.85), (0.1, 0.1, 0.1), 0)]
    assert pairing.pair_things([TABLE, MUG], boxes, [None, None, None]) == {1: 1, 2: 2}
    assert pairing.pair_things([TABLE, MUG], boxes, [1, 2, None]) == {1: 0, 2: 1}
    assert pairing.pair_things([TABLE, MUG], boxes, [None, 2, None]) == {
        2: 1
    }  # what is left near the table is too small
    assert pairing.pair_things([TABLE], [], []) == {}


def test_two_near_things_are_paired_so_that_both_are_placed() -> None:
    left, right = (replace(MUG, number=n, position=(2.0 + 0.1 * n, 2.0, 0.85)) for n in (1, 2))
    boxes = [UprightBox((2.15, 2.0, 0.85), (0.1, 0.1, 0.1), 0), UprightBox((2.24, 2.0, 0.85), (0.1, 0.1, 0.1), 0)]
    assert pairing.pair_things([left, right], boxes, [None, None]) == {1: 0, 2: 1}


def test_a_thing_in_another_counts_unless_it_is_so_in_truth() -> None:
    under = replace(MUG, number=5, position=(2.0, 2.0, 0.4), size=(0.4, 0.4, 0.7), label="stool", kind="stool")
    boxes = [TABLE.box, under.box]
    assert carrying.find_inside(boxes, {0: TABLE.box, 1: under.box})[1].tolist() == [False, False]
    assert carrying.find_inside(boxes, {0: TABLE.box})[1].tolist() == [True, True]
    apart = UprightBox((3.0, 3.5, 0.4), (0.4, 0.4, 0.8), 0.5)
    assert carrying.find_inside([TABLE.box, apart], {})[1].tolist() == [False, False]
    assert carrying.measure_overlap(UprightBox((0, 0, 0), (1, 1, 1), 0), UprightBox((0.9, 0, 0), (1, 1, 1), 0)) == (
        pytest.approx(0.1)
    )


def test_what_is_in_a_bed_s_box_stands_on_it_and_what_hangs_in_the_air_falls() -> None:
    bed = say(TABLE, size=[2.0, 1.5, 0.9], center=[2.0, 2.0, 0.45])
    pillow = say(MUG, center=[2.0, 2.2, 0.55], support="0", number=2)
    rows = score(room(bed, pillow))
    assert rows["cup"].stands and rows["dining table"].stands
    assert not score(room(say(MUG, center=[2.0, 2.2, 0.95]), say(TABLE)))["cup"].stands
    assert score(room(say(MUG, support="wall"), say(CABINET)))["cup"].stands  # it is held


def test_a_thing_that_leans_over_an_edge_tips() -> None:
    rows = score(room(say(TABLE, center=[2.0, 2.0, 0.4]), say(MUG, center=[2.0, 2.69, 0.95], size=[0.3, 0.3, 0.3])))
    assert rows["cup"].stands is False


@pytest.mark.parametrize("name", ["Dining_Table", "kitchen table 2", "KitchenTable", "desk", "table_1"])
def test_names_are_compared_by_their_words(name: str) -> None:
    assert naming.is_sensible(name, "table")
    assert not naming.is_sensible(name, "sofa") and not naming.is_sensible("", "table")


def test_shapes_are_compared_cell_by_cell() -> None:
    full, half = np.ones((24, 24, 24), bool), np.ones((24, 24, 24), bool)
    half[:, :, 12:] = False
    rows = score(room(say(TABLE)), {0: half}, {"m_table": full})
    assert rows["dining table"].shape == 0.5 and rows["cup"].shape is None


def test_what_was_drawn_over_is_not_asked_of_who_was_told_the_drawn_masks() -> None:
    truth = replace(TRUTH, joined={"2": 1})
    assert [thing.number for thing in truth.list_asked(drawn=True)] == [1, 3]
    assert [thing.number for thing in truth.list_asked(drawn=False)] == [1, 2, 3]
    assert Submission(About(**HEAD), {}, {}).rooms == {}
