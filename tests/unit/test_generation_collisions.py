"""Pushing things apart: shortest way, whole stacks, walls, the cap."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import Point

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.generation import collisions
from roomkin.stages.generation.collisions import forbidden_shifts, resolve_collisions
from roomkin.stages.generation.turning import move_out_of_walls
from roomkin.stages.geometry.boxes import UprightBox, corners
from tests.unit.generation_scenes import BACK, solid, thing, upright

OPTIONS = GenerationConfig().model_copy(update={"touch": 0.0})


def solve(items, walls=(), **options):
    items = [item if item.prisms else solid(item) for item in items]
    result = resolve_collisions(items, list(walls), OPTIONS.model_copy(update=options))
    return {item.id: item for item in result.items}, result.left


def square(x, y, half=0.5, low=0.0, high=1.0):
    corner = half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    return upright(corner + np.array([x, y]), low, high)


def test_forbidden_shifts_are_the_minkowski_difference():
    region = forbidden_shifts([square(0, 0)], [square(0.8, 0)], 0.0)
    assert region.area == pytest.approx(4.0)
    assert region.contains(Point(0, 0))
    assert not region.contains(Point(-0.21, 0))
    assert forbidden_shifts([square(0, 0)], [square(0.8, 0, low=1.0, high=2.0)], 0.0).is_empty


@pytest.mark.parametrize("walls", [(), (BACK,)])  # there is room before the wall
def test_the_smaller_one_gives_way_by_the_shortest_path(walls):
    big, small = thing("big", (2, 0, 0.5), (1, 1, 1)), thing("small", (2.6, 0.1, 0.25), (0.4, 0.4, 0.5))
    items, left = solve([big, small], walls)
    assert not left
    assert items["big"].center == pytest.approx([2, 0, 0.5])
    assert items["small"].center == pytest.approx([2.7, 0.1, 0.25], abs=1e-3)
    assert items["small"].moved == pytest.approx(0.1, abs=1e-3)


def test_what_touches_a_wall_stays_even_if_it_is_the_smaller_one():
    free = thing("free", (3.1, 0, 0.5), (1, 1, 1))
    cabinet = thing("cabinet", (3.7, 0, 0.3), (0.6, 0.5, 0.6), mounting=3, walls=["wall_1"])
    items, left = solve([free, cabinet], [BACK], push_limit=3.0)  # the cabinet could slide along its wall
    assert not left
    assert items["cabinet"].moved == 0
    assert items["free"].center == pytest.approx([2.9, 0, 0.5], abs=1e-3)


def test_what_had_moved_before_has_moved_by_both_pushes():
    big, small = thing("big", (2, 0, 0.5), (1, 1, 1)), thing("small", (2.6, 0.1, 0.25), (0.4, 0.4, 0.5))
    items, left = solve([big, replace(small, moved=0.05)])
    assert not left and items["small"].moved == pytest.approx(0.15, abs=1e-3)


def test_a_stack_moves_together():
    big, table = thing("big", (2, 0, 1), (2, 2, 2)), thing("table", (3.2, 0, 0.4), (0.6, 0.6, 0.8))
    cup = thing("cup", (3.3, 0.1, 0.851), (0.1, 0.1, 0.1), support="table")
    items, left = solve([big, table, cup])
    assert not left
    assert items["table"].center[0] == pytest.approx(3.3, abs=1e-3)
    assert items["cup"].center - items["table"].center == pytest.approx([0.1, 0.1, 0.451])


def test_a_push_makes_no_new_collision():
    left_box, right_box = thing("left", (0, 0, 0.5), (1, 1, 1)), thing("right", (1.45, 0, 0.5), (1, 1, 1))
    middle = thing("middle", (0.7, 0, 0.25), (0.5, 0.5, 0.5))  # overlaps both; the gap is 0.45 wide
    items, left = solve([left_box, right_box, middle], push_limit=2.0)
    assert not left
    assert abs(items["middle"].center[1]) > 0.7  # out sideways, since the gap is too narrow


def test_what_hangs_stays_and_what_touches_a_wall_slides_along_it():
    shelf = thing("shelf", (3.8, 0, 0.9), (0.4, 1.0, 0.4), mounting=1, walls=["wall_1"], support="wall")
    cabinet = thing("cabinet", (3.7, 0.9, 0.5), (0.6, 1.0, 1.0), mounting=3, walls=["wall_1"])
    items, left = solve([shelf, cabinet], [BACK])
    assert not left
    assert items["shelf"].center == pytest.approx([3.8, 0, 0.9])
    assert items["cabinet"].center == pytest.approx([3.7, 1.0, 0.5], abs=1e-3)


def test_what_hangs_side_by_side_slides_along_the_wall():
    hung = [thing(name, (3.8, y, 1.8), (0.4, 1.0, 0.8), mounting=1, walls=["wall_1"], support="wall")
            for name, y in (("left", 0.99), ("right", 0.0))]  # fmt: skip
    items, left = solve(hung, [BACK])
    assert not left
    assert sorted(item.moved for item in items.values()) == pytest.approx([0, 0.01], abs=1e-3)
    assert all(item.center[[0, 2]] == pytest.approx([3.8, 1.8]) for item in items.values())


def test_things_are_not_pushed_into_walls():
    cabinet = thing("cabinet", (3.0, 0, 0.5), (1.0, 3.0, 1.0))
    box = thing("box", (3.65, 0, 0.25), (0.4, 0.4, 0.5))  # shortest way out is +x, into the wall
    items, left = solve([cabinet, box], [BACK], push_limit=3.0)
    assert not left
    assert corners(items["box"].box)[:, 0].max() <= 4.0 + 1e-6


def test_things_stay_on_their_support():
    table = thing("table", (2, 0, 0.4), (0.5, 0.5, 0.8))
    a = thing("a", (2, -0.1, 0.9), (0.3, 0.3, 0.2), support="table")
    b = thing("b", (2, 0.1, 0.9), (0.29, 0.29, 0.2), support="table")
    items, left = solve([table, a, b])
    assert not left
    assert np.abs(items["b"].center[:2] - [2, 0]).max() <= 0.25 + 1e-6


def test_what_rests_on_another_or_is_higher_does_not_collide():
    table = thing("table", (2, 0, 0.4), (1, 1, 0.8))
    resting = thing("resting", (2, 0, 0.9), (0.2, 0.2, 0.2), support="table")
    lamp = thing("lamp", (2, 0.2, 2.0), (0.2, 0.2, 0.2))
    items, left = solve([table, resting, lamp], touch=0.005)
    assert not left
    assert all(item.moved == 0 for item in items.values())


def test_what_overlaps_by_millimetres_is_pushed_apart():
    """Physics throws light things over that overlap by 5 mm."""
    big, small = thing("big", (2, 0, 0.1), (0.2, 0.2, 0.2)), thing("small", (2.116, 0, 0.06), (0.04, 0.04, 0.12))
    items, left = solve([big, small], touch=GenerationConfig().touch)
    assert not left and 0.003 <= items["small"].moved < 0.004


def test_a_chair_may_stand_under_a_table_top():
    table, chair = thing("table", (2, 0, 0.4), (1.2, 1.2, 0.8)), thing("chair", (2.5, 0, 0.2), (0.5, 0.5, 0.4))
    top = upright(np.array([(-0.6, -0.6), (0.6, -0.6), (0.6, 0.6), (-0.6, 0.6)]), 0.35, 0.4)
    items, left = solve([replace(table, prisms=(top,)), chair])
    assert not left
    assert items["chair"].moved == 0


def test_what_cannot_be_freed_is_reported_and_the_loop_ends():
    a, b = thing("a", (2, 0, 0.5), (3, 3, 1)), thing("b", (2, 0, 0.5), (2.9, 2.9, 1))
    items, left = solve([a, b], push_limit=0.3)
    assert left == [("a", "b")]
    assert items["b"].moved == 0
    assert solve([a, b], push_limit=9.0, push_rounds=0)[1] == [("a", "b")]


def test_where_no_short_push_frees_anything_a_longer_one_does():
    """A piece of a sofa that was taken for an armchair lies in the sofa: physics would throw both over."""
    sofa, armchair = thing("sofa", (2, 0, 0.3), (1.6, 1.6, 0.6)), thing("armchair", (2, 0.2, 0.3), (1.0, 1.0, 0.6))
    assert solve([sofa, armchair], last_push_limit=0.5)[1] == [("armchair", "sofa")]
    items, left = solve([sofa, armchair], last_push_limit=1.2)
    assert not left and items["sofa"].moved == 0
    assert items["armchair"].moved == pytest.approx(1.1, abs=1e-3)  # to the nearest side
    near = thing("armchair", (2, 0.9, 0.3), (1.0, 1.0, 0.6))
    assert solve([sofa, near])[0]["armchair"].moved == pytest.approx(0.4, abs=1e-3)


def test_out_of_walls():
    inside = move_out_of_walls(UprightBox((3.8, 0, 0.5), (0.6, 1, 1), 0.0), [BACK])
    assert inside.center == pytest.approx([3.7, 0, 0.5])
    beyond = move_out_of_walls(UprightBox((5, 0, 0.5), (0.6, 1, 1), 0.0), [BACK])  # another room
    assert beyond.center == pytest.approx([5, 0, 0.5])


def test_shapes_are_compared_once_and_only_where_they_may_meet(monkeypatch):
    compared = []

    def count(mover, others, touch):
        compared.append((len(mover), len(others)))
        return forbidden_shifts(mover, others, touch)

    monkeypatch.setattr(collisions, "forbidden_shifts", count)
    row = [thing(f"thing_{k}", (0.9 * k, 0, 0.5), (1, 1, 1)) for k in range(12)]  # each in the next: many pushes
    items, left = solve(row, push_limit=5.0, push_rounds=60)
    pushed = sum(item.moved > 0 for item in items.values())
    assert not left and pushed > 3
    assert len(compared) <= 12 * 11  # each once from either side, whatever the number of pushes
    compared.clear()
    apart = [thing(f"thing_{k}", (3.0 * k, 0, 0.5), (1, 1, 1)) for k in range(12)]
    assert not solve(apart)[1] and not compared
    above = [thing(f"thing_{k}", (0, 0, 0.5 + 1.5 * k), (1, 1, 1)) for k in range(5)]
    assert not solve(above)[1] and not compared
