"""Camera, boxes and walls of a picture without depth."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import rotation_of
from roomkin.stages.perception.camera.metrology import UprightPlane
from roomkin.stages.perception.draw import tell_camera
from roomkin.stages.perception.drawing.room import draw_room, draw_wall
from roomkin.stages.perception.drawing.solve import solve
from roomkin.stages.perception.layout.ends import (
    FLOOR,
    NOWHERE,
    WALL,
    Ends,
    find_open,
    find_supports,
    kind_of,
    list_items,
    measure_all,
)
from roomkin.stages.perception.layout.fit import FitItem, Layout, choose_modes, list_modes
from roomkin.stages.perception.layout.room import FittedRoom, Spread, scale_room
from roomkin.stages.perception.layout.walls import find_wall, measure_rectangle
from roomkin.stages.perception.segmentation.proposal import find_border
from tests.unit.perception.room_alone import (
    BOXES,
    HEIGHT,
    LABELS,
    TRUE,
    WIDTH,
    build_once,
    outline_box,
    outline_room,
    see_lines,
    show_room,
)


def supports(masks: Any, labels: dict[int, str], ends: Any) -> dict[int, int]:
    return find_supports(masks, {value: kind_of(label) for value, label in labels.items()}, ends)


FAR_WALL = np.array([0.0, -1.0, 0.0])


def find(values: tuple[int, ...] = tuple(BOXES)) -> FittedRoom:
    return build_once(show_room(), see_lines(), outline_room(values), {value: LABELS[value] for value in values})


@pytest.fixture(scope="module")
def found() -> FittedRoom:
    return find()


def test_the_camera_is_found_by_lines_and_usual_sizes(found: FittedRoom) -> None:
    assert found.view.above == pytest.approx(TRUE.above, rel=0.1)
    assert np.degrees(np.arccos(found.view.rotation[2] @ TRUE.rotation[2])) < 1
    assert found.view.focal == pytest.approx(TRUE.focal, rel=0.05)


def test_things_are_as_far_and_as_large_as_they_are_up_to_the_scale(found: FittedRoom) -> None:
    scale = TRUE.above / found.view.above
    for value, box in BOXES.items():
        assert scale * found.boxes[value].center == pytest.approx(box.center, abs=0.1 * np.linalg.norm(box.center))
        assert np.prod(scale * found.boxes[value].size) ** (1 / 3) == pytest.approx(
            np.prod(box.size) ** (1 / 3), rel=0.25
        )


def test_what_stands_and_hangs_is_told_by_its_kind_and_by_what_is_below(found: FittedRoom) -> None:
    assert [found.on[value] for value in (1, 2, 3, 6)] == [FLOOR] * 4
    assert found.on[4] == 3 and found.boxes[4].bottom == pytest.approx(found.boxes[3].top)
    assert found.on[5] == -1 and found.walls[0].offset == pytest.approx(-4.4, rel=0.12)


def test_a_length_that_a_person_knows_gives_the_scale(found: FittedRoom) -> None:
    large = scale_room(found, LABELS, {"fridge": 3.6, "wardrobe": 1.0})
    factor = 3.6 / found.boxes[1].size[2]
    assert large.boxes[1].size[2] == pytest.approx(3.6) and large.view.above == pytest.approx(factor * found.view.above)
    assert large.walls[0].offset == pytest.approx(factor * found.walls[0].offset)
    pixels = [room.view.project(room.boxes[2].center) for room in (found, large)]
    assert pixels[0] == pytest.approx(pixels[1]), "the picture stays as it is"
    assert scale_room(found, LABELS, {"camera": 2.0}).view.above == pytest.approx(2.0)
    assert scale_room(found, LABELS, {"wardrobe": 1.0}) is found


def test_a_focal_length_of_exif_holds() -> None:
    camera = see_lines(likely_focal=700.0, spread=0.001)
    assert build_once(show_room(), camera, outline_room(), LABELS).view.focal == pytest.approx(700, rel=0.01)


def test_a_thing_that_the_picture_cuts_may_go_on_there() -> None:
    cut = UprightBox([-4.0, 4.1, 0.4], [1.5, 0.45, 0.8], 0.0)
    masks = outline_room()
    masks[outline_box(cut)] = 7
    assert (masks == 7)[:, 0].any() and (masks == 7).any(axis=0).sum() > 50
    room = build_once(show_room(), see_lines(), masks, LABELS | {7: "sideboard"})
    scale = TRUE.above / room.view.above
    assert scale * room.boxes[7].size[0] == pytest.approx(1.5, rel=0.25)
    assert np.linalg.norm(scale * room.boxes[7].center - cut.center) < 0.5


def test_a_table_whose_legs_no_outline_shows_still_stands_on_the_floor() -> None:
    masks, top = outline_room(), UprightBox([0.0, 2.6, 0.41], [1.0, 0.6, 0.06], 0.0)
    masks[(masks == 3) | (masks == 4)] = 0
    masks[outline_box(top)] = 3
    labels = {value: label for value, label in LABELS.items() if value != 4}
    room = build_once(show_room(), see_lines(), masks, labels)
    assert room.boxes[3].size[2] * TRUE.above / room.view.above == pytest.approx(0.44, rel=0.25)
    assert room.boxes[3].center[1] * TRUE.above / room.view.above == pytest.approx(2.6, rel=0.12)


def test_ends_are_cut_by_the_border_or_met_by_a_thing() -> None:
    masks = np.zeros((HEIGHT, WIDTH), np.uint16)
    masks[100:300, 0:200], masks[300:480, 50:150], masks[120:200, 203:300] = 1, 2, 3
    ends = measure_all(masks, [1, 2, 3], ~find_border(show_room()))
    assert ends[1].cut.tolist() == [True, False, False, False] and ends[2].cut.tolist() == [False, False, False, True]
    assert ends[1].met == (0, 0, 0, 0) and ends[2].met[1] == 1  # half of the foot of 1, and less than half of its side
    assert ends[3].met[0] == 1 and ends[3].limit[0] == 0.5
    assert ends[1].at.tolist() == [0.5, -99.5, 199.5, 299.5]


def test_the_nearer_of_two_things_side_by_side_hides_the_other() -> None:
    masks = np.zeros((HEIGHT, WIDTH), np.uint16)
    masks[100:300, 100:200], masks[150:400, 200:300] = 1, 2
    ends = measure_all(masks, [1, 2], ~find_border(show_room()))
    on = {1: FLOOR, 2: FLOOR}
    assert find_open(1, ends, on)[2] and not find_open(2, ends, on)[0]
    assert not find_open(1, ends, {1: 2, 2: FLOOR})[2], "what carries a thing hides it not from the side"


def test_what_only_stands_on_things_and_has_none_below_has_no_place() -> None:
    masks = outline_room((1, 4))
    ends = measure_all(masks, [1, 4], ~find_border(show_room()))
    assert supports(masks, {1: "fridge", 4: "mug"}, ends) == {1: FLOOR, 4: NOWHERE}
    assert supports(masks, {1: "fridge", 4: "picture"}, ends) == {1: FLOOR, 4: WALL}
    room = find((1, 4))
    assert set(room.boxes) == {1} and "not seen" in room.left_out[4]


def test_of_a_table_top_alone_that_is_the_ground() -> None:
    """Nothing stands there that only the floor carries: mugs and a picture, whose table is no thing."""
    masks, inside = outline_room((1, 4, 5)), ~find_border(show_room())
    labels = {4: "mug", 5: "picture"}
    assert list_items(masks, labels, inside)[1] == {4: FLOOR, 5: WALL}
    assert list_items(masks, labels | {1: "fridge"}, inside)[1] == {1: FLOOR, 4: NOWHERE, 5: WALL}


def test_nothing_stands_on_what_stands_on_it() -> None:
    masks = np.zeros((HEIGHT, WIDTH), np.uint16)
    masks[100:200, 100:200], masks[300:350, 100:200] = 1, 2
    none = np.zeros(4, bool)
    ends = {
        1: Ends(np.zeros(4), none, (0, 0, 0, 2), np.zeros(4)),
        2: Ends(np.zeros(4), none, (0, 0, 0, 1), np.zeros(4)),
    }
    assert supports(masks, {1: "thing", 2: "thing"}, ends) == {1: 2, 2: FLOOR}


def test_a_plain_frame_around_the_picture_cuts_as_its_border_does() -> None:
    masks, framed = np.zeros((HEIGHT, WIDTH), np.uint16), show_room()
    masks[100:300, 20:200], framed[:, :20] = 1, 0
    assert measure_all(masks, [1], ~find_border(framed))[1].cut.tolist() == [True, False, False, False]


def layout_of(**change: object) -> tuple[Layout, np.ndarray]:
    """A coffee table and the mug on it, and the state that shows them as they are."""
    masks = outline_room((3, 4))
    ends = measure_all(masks, [3, 4], ~find_border(show_room()))
    none = np.zeros(4, bool)
    items = [
        FitItem(ends[3], none, kind_of("coffee table").usual),
        FitItem(ends[4], none, kind_of("mug").usual, on=0),
    ]
    items[0] = replace(items[0], **change)  # type: ignore[arg-type]
    state = [*see_lines().state, np.log(TRUE.above)]
    for value in (3, 4):
        x, y, _ = BOXES[value].center
        state += [np.arctan2(x, y), np.log(np.hypot(x, y)), *np.log(BOXES[value].size)]
    return Layout(see_lines(), items), np.array(state)


def test_what_is_carried_costs_where_it_is_beside_its_carrier() -> None:
    layout, state = layout_of()
    assert (layout.measure_things(state)[2] == 0).all()
    state[10] += 0.5  # bearing of the mug
    assert layout.measure_things(state)[2][1].max() > 3


def test_an_end_that_is_hidden_is_at_the_latest_where_what_hides_it_ends() -> None:
    layout, state = layout_of()
    limit = layout.items[0].ends.at + np.array([0, 0, 60, 0])
    open_ = np.array([False, False, True, False])
    layout, _ = layout_of(ends=replace(layout.items[0].ends, limit=limit), open=open_)
    for width, off in ((1.0, 0), (1.15, 0), (2.0, 3)):
        state[7] = np.log(width)
        right = layout.measure_things(state)[0][0, 2]
        assert right == pytest.approx(0, abs=0.2) if not off else right > off
    state[7] = np.log(0.5)
    assert layout.measure_things(state)[0][0, 2] < -2, "it reaches as far as it is seen"


def test_corners_behind_the_camera_lie_on_their_side_of_the_picture() -> None:
    layout, state = layout_of()
    state[6] = np.log(0.2)  # around the camera
    pixels = layout.project(state)[0]
    assert (
        np.isfinite(pixels).all()
        and pixels[:, 0].min() < 0
        and pixels[:, 0].max() > WIDTH
        and pixels[:, 1].max() > HEIGHT
    )


def test_a_table_that_is_seen_whole_lacks_no_legs_and_seats_may_stand_across() -> None:
    layout, state = layout_of(legs=True)
    chosen = choose_modes(see_lines(), layout.items[:1], state[:5])[0][0]
    assert not chosen.endless and chosen.penalty == 0
    yaws = {round(np.degrees(mode.yaw)) for mode in list_modes(replace(layout.items[0], across=True))}
    assert yaws == {0, 45, 90, 135}


def test_a_wall_wants_furniture_and_a_line_or_what_hangs() -> None:
    line = np.array([TRUE.project([(-3, 4.4, 0), (1, 4.4, 0)])])
    none = np.zeros((0, 2, 2))
    fridge, sofa = BOXES[1], BOXES[2]
    assert find_wall(TRUE, FAR_WALL, [fridge], [True], none, []) is None
    both = find_wall(TRUE, FAR_WALL, [fridge], [True], line, [])
    assert both is not None and both.offset == pytest.approx(-4.4, abs=0.05)
    for a, b in (((-3, 4.0, 0), (-1, 4.9, 0)), ((-1, 60, TRUE.above), (1, 60, TRUE.above))):  # askew; on the horizon
        with warnings.catch_warnings(action="error"):
            assert find_wall(TRUE, FAR_WALL, [fridge], [True], np.array([TRUE.project([a, b])]), []) is None
    beyond = UprightBox([0, 6.5, 0.5], [1, 1, 1], 0.0)
    assert find_wall(TRUE, FAR_WALL, [fridge, beyond], [True, False], line, []) is None
    hung = find_wall(TRUE, FAR_WALL, [fridge, sofa], [False, False], none, [4.2])
    assert hung is not None and hung.offset == pytest.approx(-4.2, abs=0.3)


def test_what_a_wall_does_not_face_is_no_rectangle_on_it() -> None:
    mask = outline_box(BOXES[5])
    assert measure_rectangle(TRUE, UprightPlane(FAR_WALL, -4.4), mask)[0] > 0.9
    assert measure_rectangle(TRUE, UprightPlane(-FAR_WALL, -4.4), mask)[0] == 0


def test_a_wall_behind_the_camera_is_not_drawn() -> None:
    assert draw_wall(TRUE, "wall_1", UprightPlane(-FAR_WALL, -4.4)) is None
    assert draw_wall(TRUE, "wall_1", UprightPlane(FAR_WALL, -4.4)) is not None


def test_a_drawing_gives_the_boxes_again(found: FittedRoom) -> None:
    project, known, left_out = draw_room("room.png", found, outline_room(), LABELS)
    solved = solve(project)
    assert left_out == {} and all(item.unsure and item.outlines for item in project.objects)
    assert solved.view.above == pytest.approx(found.view.above, abs=1e-3)
    for value, box in found.boxes.items():
        again = solved.boxes[f"thing_{value}"]
        assert again.center == pytest.approx(box.center, abs=0.05), LABELS[value]
        assert np.sort(again.size) == pytest.approx(np.sort(box.size), abs=0.06), LABELS[value]
        assert known.boxes[f"thing_{value}"] is box, "what is known is not solved again"
    assert known.walls["wall_1"].ends == pytest.approx(solved.walls["wall_1"].ends, abs=0.02)
    assert known.view == solved.view or known.view.rotation == pytest.approx(solved.view.rotation)
    assert not any(item.free for item in project.objects) and project.untouched
    on = {item.id: item.on for item in project.objects}
    assert on["thing_4"] == "thing_3" and on["thing_5"] == "wall_1" and on["thing_1"] == "floor"


def test_what_stands_on_what_cannot_be_drawn_is_left_out_with_it(found: FittedRoom) -> None:
    behind = UprightBox([0, 0, 0.2], [1, 1, 0.4], 0.0)  # below the camera
    room = replace(found, boxes=found.boxes | {3: behind})
    project, _, left_out = draw_room("room.png", room, outline_room(), LABELS)
    assert "behind the camera" in left_out[3] and "no place" in left_out[4]
    on_it = replace(room, boxes=room.boxes | {7: room.boxes[4]}, on=room.on | {7: 4})
    assert "no place" in draw_room("room.png", on_it, outline_room(), LABELS | {7: "mug"}).left_out[7]
    assert {item.id for item in project.objects} == {"thing_1", "thing_2", "thing_5", "thing_6"}


def test_each_number_of_the_camera_has_its_spread(found: FittedRoom) -> None:
    spread = found.spread
    assert abs(np.log(found.view.above / TRUE.above)) < 2 * spread.height < 0.4
    assert abs(np.log(found.view.focal / TRUE.focal)) < 2 * spread.focal and np.degrees(spread.tilt) < 2
    assert find((1,)).spread.height > 1.2 * spread.height, "fewer things tell less"
    nothing = build_once(show_room(), see_lines(), np.zeros((HEIGHT, WIDTH), np.uint16), {})
    assert nothing.spread.height > 0.19 and nothing.spread.tilt == pytest.approx(spread.tilt, rel=0.2)
    assert scale_room(found, LABELS, {"camera": 1.45}).spread == spread._replace(height=0)


def test_the_camera_is_told_in_metres_degrees_and_pixels(found: FittedRoom) -> None:
    room = replace(found, view=TRUE, spread=Spread(tilt=np.radians(2), height=0.2, focal=0.05), doubt="")
    sides = "above the floor and looks 16.0 degrees (± 2.0) down, its focal length is 520 pixels (± 26)"
    assert tell_camera(room) == f"the camera is 1.45 m (± 0.29) {sides}"
    sure = replace(room, spread=room.spread._replace(height=0.0))
    assert tell_camera(sure) == f"the camera is 1.45 m {sides}", "a person told it"


def test_lines_that_no_thing_agrees_with_are_told(found: FittedRoom) -> None:
    labels = {value: LABELS[value] for value in BOXES}
    askew = replace(TRUE, rotation=rotation_of(0.25, -0.28 - np.radians(12), 0.0))
    room = build_once(show_room(), see_lines(view=askew), outline_room(), labels)
    assert found.doubt == "" and "by its lines the camera looks 28 degrees down, by its things 15" in room.doubt
    assert room.doubt in tell_camera(room)
