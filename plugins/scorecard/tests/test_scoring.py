"""What is right about a submission, and what is not: one room whose truth is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from roomkin.plugins.scorecard import card, measures, placing, scoring, standing
from roomkin.plugins.scorecard.scoring import ThingRow
from roomkin.plugins.scorecard.tests.rooms import CABINET, HEAD, MUG, POSE, TABLE, TRUTH, room, say
from roomkin.plugins.scorecard.truth import About, PictureTruth, RoomScene, Submission, SubmittedRoom, TrueHandle
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import invert_transform, transform_points

RIGHT = ["placed", "sensible", "size", "place", "carrier", "clear", "stands"]


def score(
    document: dict[str, Any], solids: Any = None, shapes: Any = None, truth: PictureTruth = TRUTH
) -> dict[str, ThingRow]:
    """Rows by label."""
    scene = RoomScene(SubmittedRoom.model_validate(document), solids or {})
    asked = truth.list_asked(drawn=False)
    placed = placing.place_room(scene.room, truth, asked)
    return {row.label: row for row in scoring.score_room(truth, asked, scene, placed, shapes or {})}


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


@pytest.mark.parametrize(
    ("points", "right"),
    [
        ([(0.0, -0.2, 0.1), (0.0, 0.2, 0.1)], True),
        ([(0.0, 0.2, -0.2), (0.03, -0.23, 0.1)], True),  # along a bar, and beside a knob
        ([(0.0, 0.2, 0.1), (0.0, 0.2, 0.3)], False),  # both at one door
        ([(0.0, -0.2, 0.1)], False),
        ([(0.0, -0.2, 0.1), (0.0, 0.2, 0.1), (0.0, 0.0, 0.1)], False),  # one at none
        ([(0.0, -0.2, 0.1), (0.0, -0.1, 0.1), (0.0, 0.2, 0.1)], True),  # a drawer with two knobs
        ([(0.06, -0.2, 0.1), (0.0, 0.2, 0.1)], False),
        ([], False),
    ],
)
def test_every_door_has_a_handle_near_the_true_one(points: list[tuple[float, float, float]], right: bool) -> None:
    turned = replace(CABINET, yaw=np.pi / 2, handles=(
        TrueHandle(0, (0.31, -0.2, 0.1), (0, 0, 0)), TrueHandle(0, (0.31, -0.1, 0.1), (0, 0, 0)),
        TrueHandle(1, (0.31, 0.2, 0.1), (0.02, 0.02, 0.6)),
    ))  # fmt: skip
    own = np.reshape(points, (-1, 3)) + np.array([0.31, 0, 0])
    world = own @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + turned.position
    assert measures.are_handles_right(turned, world) is right
    assert measures.are_handles_right(CABINET, world) is None


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_handles_are_scored_in_every_frame(scale: float) -> None:
    known = replace(CABINET, handles=(TrueHandle(0, (0.31, 0.25, 0.0), (0.02, 0.02, 0.2)),))
    truth = replace(TRUTH, things=[TABLE, known])
    camera = invert_transform(POSE)
    things = []
    for thing in truth.things:
        handles = [transform_points(camera, thing.position + np.array([0.31, 0.25, 0.04]))] if thing.opens else []
        center = scale * transform_points(camera, thing.position)
        said = say(thing, center=center.tolist(), size=(scale * np.array(thing.size)).tolist())
        things.append(said | {"handles": [(scale * point).tolist() for point in handles]})
    document = {"frame": "camera", "scale": "metric" if scale == 1 else "free", "things": things}
    rows = score(document, truth=truth)
    assert rows["cupboard"].handle is True and rows["dining table"].handle is None
    things[1].pop("handles")
    assert score(document, truth=truth)["cupboard"].handle is False
    assert score({"frame": "camera", "things": []}, truth=truth)["cupboard"].handle is False


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
    assert placing.pair_things([TABLE, MUG], boxes, [None, None, None]) == {1: 1, 2: 2}
    assert placing.pair_things([TABLE, MUG], boxes, [1, 2, None]) == {1: 0, 2: 1}
    assert placing.pair_things([TABLE, MUG], boxes, [None, 2, None]) == {
        2: 1
    }  # what is left near the table is too small
    assert placing.pair_things([TABLE], [], []) == {}


def test_two_near_things_are_paired_so_that_both_are_placed() -> None:
    left, right = (replace(MUG, number=n, position=(2.0 + 0.1 * n, 2.0, 0.85)) for n in (1, 2))
    boxes = [UprightBox((2.15, 2.0, 0.85), (0.1, 0.1, 0.1), 0), UprightBox((2.24, 2.0, 0.85), (0.1, 0.1, 0.1), 0)]
    assert placing.pair_things([left, right], boxes, [None, None]) == {1: 0, 2: 1}


def test_a_thing_in_another_counts_unless_it_is_so_in_truth() -> None:
    under = replace(MUG, number=5, position=(2.0, 2.0, 0.4), size=(0.4, 0.4, 0.7), label="stool", kind="stool")
    boxes = [TABLE.box, under.box]
    assert standing.find_inside(boxes, {0: TABLE.box, 1: under.box})[1].tolist() == [False, False]
    assert standing.find_inside(boxes, {0: TABLE.box})[1].tolist() == [True, True]
    apart = UprightBox((3.0, 3.5, 0.4), (0.4, 0.4, 0.8), 0.5)
    assert standing.find_inside([TABLE.box, apart], {})[1].tolist() == [False, False]
    assert standing.measure_overlap(UprightBox((0, 0, 0), (1, 1, 1), 0), UprightBox((0.9, 0, 0), (1, 1, 1), 0)) == (
        pytest.approx(0.1)
    )


def test_what_is_in_a_bed_s_box_stands_on_it_and_what_hangs_in_the_air_falls() -> None:
    bed = say(TABLE, size=[2.0, 1.5, 0.9], center=[2.0, 2.0, 0.45])
    pillow = say(MUG, center=[2.0, 2.2, 0.55], support="0", number=2)
    rows = score(room(bed, pillow))
    assert rows["cup"].stands and rows["dining table"].stands
    assert not score(room(say(MUG, center=[2.0, 2.2, 0.95]), say(TABLE)))["cup"].stands
    assert score(room(say(MUG, support="wall"), say(CABINET)))["cup"].stands  # it is held


def test_depths_are_those_of_pieces_alone() -> None:
    boxes = [UprightBox((x, 0, 0.5), (1, 1, 1), 0.0) for x in (0, 0.9, 5, 5.9)]
    piece = np.asarray(trimesh.creation.box((1, 1, 1)).vertices)
    depths = standing.measure_depths(boxes, {3: [piece]})
    assert depths[2, 3] == depths[3, 2] == pytest.approx(0.1, abs=0.01) and np.count_nonzero(depths) == 2


def test_pieces_that_miss_an_end_or_have_no_thickness_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def cut(*extents: tuple[float, float, float]) -> int:
        pieces = [{"vertices": trimesh.creation.box(each).vertices} for each in extents]
        monkeypatch.setattr(trimesh.decomposition, "convex_decomposition", lambda *_, **__: pieces)
        return len(standing.cut_solid(trimesh.creation.box((1, 1, 1)), UprightBox((0, 0, 0), (1, 1, 1), 0.0)))

    assert cut((1, 1, 1), (1, 1, 0)) == 1
    assert cut((1, 1, 0.97), (1, 1, 0.5)) == 2 and cut((1, 1, 0.9), (1, 1, 0.5)) == 0


def test_a_thing_that_leans_over_an_edge_tips() -> None:
    rows = score(room(say(TABLE, center=[2.0, 2.0, 0.4]), say(MUG, center=[2.0, 2.69, 0.95], size=[0.3, 0.3, 0.3])))
    assert rows["cup"].stands is False


@pytest.mark.parametrize("name", ["Dining_Table", "kitchen table 2", "KitchenTable", "desk", "table_1"])
def test_names_are_compared_by_their_words(name: str) -> None:
    assert measures.is_sensible(name, "table")
    assert not measures.is_sensible(name, "sofa") and not measures.is_sensible("", "table")


def test_shapes_are_compared_cell_by_cell() -> None:
    full, half = trimesh.creation.box(TABLE.size), np.ones((24, 24, 24), bool)
    half[:, :, 12:] = False
    rows = score(room(say(TABLE)), {0: full}, {"m_table": half})
    assert rows["dining table"].shape == 0.5 and rows["cup"].shape is None


def test_what_was_drawn_over_is_not_asked_of_who_was_told_the_drawn_masks() -> None:
    truth = replace(TRUTH, joined={"2": 1})
    assert [thing.number for thing in truth.list_asked(drawn=True)] == [1, 3]
    assert [thing.number for thing in truth.list_asked(drawn=False)] == [1, 2, 3]
    assert Submission(About(**HEAD), {}, {}).rooms == {}


def frame_of(size: tuple[float, float, float]) -> trimesh.Trimesh:
    """A table's top on four legs, in the frame of its box."""
    x, y, z = np.array(size) / 2
    top = trimesh.creation.box((2 * x, 2 * y, 0.04)).apply_translation((0, 0, z - 0.02))
    legs = [
        trimesh.creation.box((0.05, 0.05, 2 * z)).apply_translation((a * (x - 0.025), b * (y - 0.025), 0))
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    return trimesh.util.concatenate([top, *legs])


def test_what_is_under_a_table_is_in_its_box_and_not_in_its_mesh() -> None:
    under = say(CABINET, center=[2.0, 2.0, 0.3], size=[0.4, 0.4, 0.6])
    boxes = score(room(say(TABLE), under))["dining table"]
    assert not boxes.clear and not boxes.shaped
    legs, box = frame_of(TABLE.size), trimesh.creation.box((0.4, 0.4, 0.6))
    for meshes in ({0: legs}, {0: legs, 1: box}):
        row = score(room(say(TABLE), under), meshes)["dining table"]
        assert row.clear and row.stands and row.shaped
    higher = say(CABINET, center=[2.0, 2.0, 0.45], size=[0.4, 0.4, 0.9])
    assert not score(room(say(TABLE), higher), {0: legs, 1: box})["dining table"].clear  # through the top


def test_a_mesh_stands_on_its_legs_and_a_box_on_all_of_it() -> None:
    lame = trimesh.creation.box((0.05, 0.05, 0.8)).apply_translation((0.37, 0.67, 0))
    lame = trimesh.util.concatenate([trimesh.creation.box((0.8, 1.4, 0.04)).apply_translation((0, 0, 0.38)), lame])
    assert score(room(say(TABLE)))["dining table"].stands
    assert not score(room(say(TABLE)), {0: lame})["dining table"].stands
    assert score(room(say(TABLE), say(MUG)), {0: frame_of(TABLE.size)})["cup"].stands


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_meshes_grow_with_their_boxes(scale: float) -> None:
    camera = invert_transform(POSE)
    things = []
    for thing in (TABLE, MUG, CABINET):
        center = scale * transform_points(camera, thing.position)
        things.append(say(thing, center=center.tolist(), size=(scale * np.array(thing.size)).tolist()))
    document = {"frame": "camera", "scale": "metric" if scale == 1 else "free", "things": things}
    rows = score(document, {0: frame_of(TABLE.size)})
    assert all(row.clear and row.stands for row in rows.values())


def test_what_has_no_volume_stands_as_its_box() -> None:
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    row = score(room(say(TABLE)), {0: flat})["dining table"]
    assert row.stands and not row.shaped


def test_a_row_says_what_stands_for_the_things() -> None:
    rows = score(room(say(TABLE), say(CABINET)), {0: frame_of(TABLE.size)})
    table = card.make_frame(list(rows.values()), scoring.ThingRow)
    assert card.describe_shapes(table) == "1 meshes, 1 boxes"
    assert card.describe_shapes(table.assign(shaped=False)) == "boxes"
    assert card.describe_shapes(table[table["shaped"]]) == "meshes"
