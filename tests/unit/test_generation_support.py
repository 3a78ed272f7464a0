"""What stands on what, at which height, and against which wall (paper A.3)."""

from dataclasses import replace

import numpy as np
import pytest

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.objects import Wall
from roomkin.stages.generation import stacking
from roomkin.stages.generation.collisions import resolve_collisions
from roomkin.stages.generation.placed import Placed
from roomkin.stages.generation.stacking import find_stack, find_supports, find_surface, put_on_supports, sort_by_height
from roomkin.stages.generation.turning import extend_to_wall
from roomkin.stages.geometry.boxes import THINNEST, UprightBox, corners
from roomkin.stages.geometry.frames import yaw_matrix
from tests.unit.askew_desk import ASKEW_DESK
from tests.unit.generation_scenes import BACK, solid, thing, upright

TABLE = thing("table", (2, 0, 0.375), (0.8, 1.2, 0.75))
BOOK = thing("book", (2, 0.2, 0.8), (0.2, 0.3, 0.05))
CUP = thing("cup", (2, 0.2, 0.87), (0.08, 0.08, 0.1))


def tree(items, overlap=0.7, tolerance=0.15):
    return find_supports(sort_by_height(items), overlap, tolerance, known_categories())


def stacked(items, options=GenerationConfig()):  # noqa: B008
    return stacking.assign_supports(items, {}, {}, options, known_categories())


def test_things_of_one_height_come_by_id_whatever_the_order():
    one, other = thing("a", (1, 0, 0.2), (0.3, 0.3, 0.4)), thing("b", (2, 0, 0.2), (0.3, 0.3, 0.4))
    assert sort_by_height([other, one]) == sort_by_height([one, other]) == [one, other]


def test_a_stack_is_found_whatever_the_order():
    assert tree([CUP, BOOK, TABLE]) == {"table": "floor", "book": "table", "cup": "book"}


@pytest.mark.parametrize(("y", "support"), [(0.565, "floor"), (0.555, "table")])
def test_seventy_percent_of_the_smaller_footprint(y, support):
    edge = thing("edge", (2, y, 0.85), (0.2, 0.2, 0.2))  # table ends at y = 0.6: 67.5 and 72.5 % of it are over it
    assert tree([TABLE, edge], tolerance=None)["edge"] == support


def test_a_large_thing_on_a_small_one_counts_the_smaller_footprint():
    stool = thing("stool", (2, 0, 0.2), (0.3, 0.3, 0.4))
    board = thing("board", (2, 0, 0.45), (1.0, 1.0, 0.1))
    assert tree([stool, board])["board"] == "stool"


def test_a_chair_under_a_table_is_not_on_it():
    chair = thing("chair", (2, 0, 0.45), (0.5, 0.5, 0.9))  # its center is higher than the table's
    assert tree([TABLE, chair])["chair"] == "floor"
    assert tree([TABLE, chair], tolerance=None)["chair"] == "table"  # the paper's rule alone


def test_the_highest_support_wins():
    low = thing("low", (2, 0, 0.1), (1, 1, 0.2))
    assert tree([low, TABLE, BOOK])["book"] == "table"


def test_what_was_seen_to_carry_a_thing_carries_it_whatever_size_its_cousin_has():
    low, small = thing("low", (2, 0, 0.2), (0.6, 0.6, 0.4)), thing("small", (2.3, 0, 0.2), (0.3, 0.3, 0.4))
    upper = thing("upper", (2, 0, 0.6), (0.6, 0.6, 0.2), support="small")  # overlaps a quarter of what it is on
    assert tree([low, small, upper])["upper"] == "small"
    assert tree([low, small, upper], tolerance=None)["upper"] == "low", "as in the paper"
    assert tree([small, replace(upper, box=replace(upper.box, center=(2, 0, 0.9)))])["upper"] == "small"


def test_stacks():
    supports = {"table": "floor", "book": "table", "cup": "book", "lamp": "floor"}
    assert find_stack("table", supports) == {"table", "book", "cup"}


def test_heights_follow_the_supports():
    floating = thing("book", (2, 0.2, 0.85), (0.2, 0.3, 0.05))
    sunk = thing("table", (2, 0, 0.35), (0.8, 1.2, 0.75))
    placed = put_on_supports([sunk, floating], {"table": "floor", "book": "table"})
    assert [item.box.bottom for item in placed] == pytest.approx([0, 0.75])
    assert placed[1].support == "table"


def test_type_1_is_only_lifted():
    counter = thing("counter", (3.7, 0, 0.45), (0.6, 1, 0.9))
    clear = thing("clear", (3.85, 0, 1.6), (0.3, 1, 0.6), mounting=1)
    sunk = thing("sunk", (3.85, 0, 1.1), (0.3, 1, 0.6), mounting=1)  # bottom at 0.8
    supports = {"counter": "floor", "clear": "counter", "sunk": "counter"}
    heights = {item.id: item for item in put_on_supports([counter, sunk, clear], supports)}
    assert heights["clear"].box.bottom == pytest.approx(1.3)
    assert heights["sunk"].box.bottom == pytest.approx(0.9)
    assert heights["clear"].support == heights["sunk"].support == "wall"


@pytest.mark.parametrize("rear", [3.7, 4.2])  # short of the wall, and in it
@pytest.mark.parametrize(("yaw", "axis"), [(np.pi, 0), (0.0, 0), (np.pi / 2, 1)])
def test_rear_to_the_wall_front_stays(rear, yaw, axis):
    front, size = 3.4, [0.9, 0.9, 1.0]
    size[axis] = rear - front
    box = extend_to_wall(UprightBox(((front + rear) / 2, 0.3, 0.5), size, yaw), BACK)
    assert box.size[axis] == pytest.approx(0.6)
    assert box.size[1 - axis] == 0.9
    assert corners(box)[:, 0].max() == pytest.approx(4.0)
    assert corners(box)[:, 0].min() == pytest.approx(front)
    assert box.center[1] == pytest.approx(0.3)


def test_a_box_turned_against_the_wall_reaches_it_but_not_into_it():
    """The second wall of a corner that was found 10 degrees askew: the box keeps its distance from the first."""
    turn = np.deg2rad(10)
    box = extend_to_wall(UprightBox((3.5, 0.3, 0.5), (0.6, 0.9, 1.0), turn), BACK)
    first = np.array([-np.sin(turn), np.cos(turn), 0])  # normal of the other wall
    before, after = corners(UprightBox((3.5, 0.3, 0.5), (0.6, 0.9, 1.0), turn)), corners(box)
    assert after[:, 0].max() == pytest.approx(4.0)
    assert after[:, 0].min() == pytest.approx(before[:, 0].min())
    assert [(after @ first).min(), (after @ first).max()] == pytest.approx(
        [(before @ first).min(), (before @ first).max()]
    )


def test_a_front_behind_the_wall_leaves_a_thin_box():
    box = extend_to_wall(UprightBox((4.1, 0, 1), (0.1, 1, 1), np.pi), BACK)
    assert box.size[0] == THINNEST
    assert box.center[0] == pytest.approx(4 - THINNEST / 2)


def test_a_wall_at_an_odd_angle_is_left_alone():
    slanted = Wall(id="w", normal=(-np.sqrt(0.5), np.sqrt(0.5), 0), offset=-3, points=9)
    box = UprightBox((2, 0, 1), (0.1, 1, 1), 0.0)
    assert extend_to_wall(box, slanted) is box


def test_what_noise_moved_over_the_edge_of_a_cabinet_still_stands_on_it():
    cabinet, pot = thing("cabinet", (2, 0, 0.4), (0.6, 0.6, 0.8)), thing("pot", (1.65, 0, 0.9), (0.3, 0.3, 0.2))
    assert find_supports([cabinet, pot], 0.7, 0.15, {})["pot"] == "cabinet"
    assert find_supports([cabinet, pot], 0.7, None, {})["pot"] == "floor"
    assert find_supports([cabinet, thing("pot", (1.65, 0, 0.1), (0.3, 0.3, 0.2))], 0.7, 0.15, {})["pot"] == "floor"
    other = thing("other", (1, 0, 0.4), (0.6, 0.6, 0.8))
    aside, far = (thing("pot", (x, 0, 0.9), (0.2, 0.2, 0.2)) for x in (1.55, 1.4))  # 5 and 20 cm before the cabinet
    assert find_supports([cabinet, other, aside], 0.7, 0.15, {})["pot"] == "cabinet"
    assert find_supports([cabinet, far], 0.7, 0.15, {})["pot"] == "unnamed"


def test_a_table_over_a_stool_stands_on_the_floor():
    stool, table = thing("stool", (2, 0, 0.07), (0.3, 0.3, 0.14)), thing("table", (2, 0, 0.375), (0.8, 1.2, 0.75))
    assert tree([stool, table])["table"] == "floor"
    assert tree([stool, replace(table, id="box", label="box")])["box"] == "stool"


def test_what_is_seen_high_above_all_that_was_named_stands_on_a_shelf_and_stays_there():
    jar, book = thing("jar", (2, 0, 0.1), (0.1, 0.1, 0.2)), thing("book", (2, 0, 0.85), (0.2, 0.3, 0.1))
    cup = thing("cup", (2, 0, 0.95), (0.08, 0.08, 0.1))
    supports = tree([jar, book, cup])
    assert supports == {"jar": "floor", "book": "unnamed", "cup": "book"}
    assert tree([jar, book], tolerance=None)["book"] == "jar"  # the paper's rule alone
    placed = {item.id: item for item in put_on_supports(sort_by_height([jar, book, cup]), supports)}
    assert placed["book"].center == pytest.approx([2, 0, 0.85]) and placed["book"].support == "unnamed"
    assert placed["cup"].box.bottom == pytest.approx(0.9)
    hung = thing("hung", (2, 0, 1.5), (0.1, 0.5, 0.5), mounting=1)
    assert put_on_supports([hung], tree([hung]))[0].support == "wall"


def block(x, y, half_x, half_y, low, high):
    """A piece of a support, in the asset frame."""
    corner = np.array([(-half_x, -half_y), (half_x, -half_y), (half_x, half_y), (-half_x, half_y)])
    return upright(corner + np.array([x, y]), low, high)


CHAIR = thing("chair", (2, 0, 0.45), (0.44, 0.44, 0.9))  # seat at 0.46, back at x = 1.8, 4 cm thick
PIECES = [block(0, 0, 0.22, 0.22, -0.02, 0.01), block(-0.2, 0, 0.02, 0.22, 0.0, 0.45)]
PIECES += [block(x, y, 0.02, 0.02, -0.45, -0.02) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
CHAIR = replace(CHAIR, prisms=tuple(PIECES))


@pytest.mark.parametrize("bottom", [0.46, 0.9])  # of a bottle on a chair; on a stool that a chair takes the place of
@pytest.mark.parametrize("x", [1.8, 1.83, 2.1])  # in the back, half in it, clear of it
def test_what_stands_on_a_chair_stands_on_its_seat_clear_of_the_back(x, bottom):
    bottle = thing("bottle", (x, 0.05, bottom + 0.15), (0.08, 0.08, 0.3))
    result = resolve_collisions(stacked([solid(bottle), CHAIR]), [], GenerationConfig())
    items = {item.id: item for item in result.items}
    assert items["bottle"].support == "chair" and not result.left
    assert items["bottle"].box.bottom == pytest.approx(0.46)
    assert items["bottle"].center[0] == pytest.approx(max(x, 1.82 + 0.04), abs=0.006)  # touching is no collision
    assert items["chair"].moved == 0


def test_a_wide_board_lies_on_a_narrow_stool():
    """What is narrow beside its support may still carry something wider."""
    board = thing("board", (2, 0, 0.9), (1.0, 1.0, 0.1))
    stool = thing("stool", (2, 0, 0.2), (0.3, 0.3, 0.5))
    seat = replace(stool, prisms=(block(0, 0, 0.15, 0.15, -0.2, 0.2),))  # 5 cm below its top
    assert find_surface(board, seat).height == pytest.approx(0.4)
    assert find_surface(board, stool).height == stool.box.top


def test_pieces_whose_edges_nearly_meet_are_joined_and_cut() -> None:
    desk, laptop = (
        thing("desk", (3.37, 1.29, 0.4), (0.56, 1.54, 0.8), -2.19),
        thing("laptop", (3.59, 1.05, 0.9), (0.1,) * 3),
    )
    turn, (x, y, z) = yaw_matrix(desk.box.yaw)[:2, :2], desk.center
    pieces = [upright((np.array(outline) - [x, y]) @ turn, -z, top - z) for top, outline in ASKEW_DESK]
    assert find_surface(laptop, replace(desk, prisms=tuple(pieces))).height == pytest.approx(0.62481, abs=1e-5)


FRONT = (  # the top begins at x = 1.78, the door, 5 mm lower, at 1.75, its handle at 1.7
    block(0.04, 0, 0.26, 0.3, -0.4, 0.4),
    block(-0.235, 0, 0.015, 0.3, -0.4, 0.395),
    block(-0.275, 0, 0.025, 0.1, 0.1, 0.12),
)
CABINET = replace(thing("cabinet", (2, 0, 0.4), (0.6, 0.6, 0.8)), prisms=FRONT)


@pytest.mark.parametrize(("x", "y", "to"), [(1.77, 0.0, 1.8), (1.9, 0.25, 1.9), (2.35, 0.0, 2.28)])
def test_what_stands_over_an_edge_is_moved_in_so_far_that_it_does_not_fall(x, y, to):
    """Over the door's upper edge; on the top; behind it, since far away a cabinet is found too shallow."""
    pot = solid(thing("pot", (x, y, 0.9), (0.2, 0.2, 0.2)))
    placed = {item.id: item for item in stacked([CABINET, pot])}["pot"]
    assert placed.support == "cabinet" and placed.center[:2] == pytest.approx([to, y])
    paper = stacked([CABINET, pot], GenerationConfig(stack_tolerance=None))
    assert {item.id: item for item in paper}["pot"].center[:2] == pytest.approx([x, y])


def light(item: Placed, mass: float) -> Placed:
    return replace(item, asset=item.asset.model_copy(update={"mass": mass}))


@pytest.mark.parametrize(
    ("mass", "to", "mounting"), [(0.01, 2.0323, 2), (0.2, 2.0384, 2), (50.0, 2.09, 2), (0.01, 2.09, 1)]
)
def test_what_stands_on_a_light_thing_stays_over_its_feet(mass, to, mounting):
    """A lid of 20 cm on a foot of 10: over the lid's border a thing of 1 kg tips a thing of 10 g over, not a table,
    nor what hangs on a wall."""
    stand = light(thing("stand", (2, 0, 0.15), (0.2, 0.2, 0.3), mounting=mounting), mass)
    can = thing("can", (2.095, 0, 0.4), (0.1, 0.1, 0.2))
    pieces = block(0, 0, 0.05, 0.05, -0.15, 0.1), block(0, 0, 0.1, 0.1, 0.1, 0.15)
    placed = {item.id: item for item in stacked([replace(stand, prisms=pieces), solid(can)])}["can"]
    assert placed.support == "stand" and placed.center[0] == pytest.approx(to, abs=1e-4)


def test_what_is_pushed_on_a_cabinet_stays_behind_its_handles():
    pot = thing("pot", (1.85, 0, 0.9), (0.2, 0.2, 0.2), support="cabinet")
    box = thing("box", (2.0, 0, 0.95), (0.25, 0.5, 0.3), support="cabinet")  # larger, so it stays
    result = resolve_collisions([CABINET, solid(pot), solid(box)], [], GenerationConfig())
    items = {item.id: item for item in result.items}
    assert items["pot"].center[0] >= 1.8 - 1e-6 and items["pot"].moved > 0
