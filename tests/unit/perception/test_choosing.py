"""The choice among proposals."""

import numpy as np

from roomkin.stages.config.perception import SeeSection
from roomkin.stages.perception.segmentation import pieces
from roomkin.stages.perception.segmentation.choosing import Chooser, choose
from roomkin.stages.perception.segmentation.mobile_sam import choose_clicks
from roomkin.stages.perception.segmentation.proposal import find_border
from tests.unit.perception.room_with_depth import ON_TABLE, TABLE, propose_mask, see_room


def iou(one: np.ndarray, other: np.ndarray) -> float:
    return float((one & other).sum() / (one | other).sum())


def test_what_stands_on_a_table_is_taken_out_of_it() -> None:
    view, (table, mug) = see_room(TABLE, ON_TABLE)
    things = choose(view, [propose_mask(view, table | mug, **{"dining table": 0.8}), propose_mask(view, mug)])
    assert [thing.words for thing in things] == [{"dining table": 0.8}, {}]
    assert iou(things[0].mask, table) > 0.85 and iou(things[1].mask, mug) > 0.7
    assert not (things[0].mask & things[1].mask).any()


def test_a_cushion_belongs_to_its_couch() -> None:
    view, (seat, cushion) = see_room(((2.4, -0.8, 0.0), (3.2, 0.8, 0.45)), ((2.9, -0.5, 0.45), (3.1, 0.0, 0.8)))
    (couch,) = choose(view, [propose_mask(view, seat | cushion, couch=0.9), propose_mask(view, cushion)])
    assert iou(couch.mask, seat | cushion) > 0.9


def test_legs_belong_to_their_table() -> None:
    view, (table, leg) = see_room(TABLE, ((2.25, -0.55, 0.0), (2.35, -0.45, 0.68)))
    whole = propose_mask(view, table | leg, **{"dining table": 0.8})
    top = propose_mask(view, table)
    (thing,) = choose(view, [type(whole)(top.logits, 0.9, "test", whole.words, whole.box), propose_mask(view, leg)])
    assert iou(thing.mask, table | leg) > 0.85


def test_ground_and_wall_are_no_things_and_a_picture_is() -> None:
    view, (picture,) = see_room(((3.96, -0.5, 1.2), (4.0, 0.3, 1.8)))
    floor, wall = view.surfaces.floor, view.surfaces.wall_masks[0]
    piece = np.zeros_like(wall)
    piece[:60, :100] = True
    proposals = [propose_mask(view, mask, 0.99) for mask in (floor, wall, piece & wall, picture)]
    (thing,) = choose(view, proposals)
    assert thing.flat and iou(thing.mask, picture) > 0.85


def test_what_covers_much_of_the_picture_is_wall_and_no_picture() -> None:
    for side, hangs in ((0.6, True), (1.2, False)):
        view, (poster,) = see_room(((3.96, -side, 1.2 - side), (4.0, side, 1.2 + side)))
        assert bool(choose(view, [propose_mask(view, poster, 0.99)])) is hangs


def test_a_known_thing_may_hang_flat() -> None:
    view, (picture,) = see_room(((3.96, -0.5, 1.2), (4.0, 0.3, 1.8)))
    (thing,) = choose(view, [propose_mask(view, picture, 0.9, tv=0.4)])
    assert thing.flat and thing.words == {"tv": 0.4}
    (wall,) = choose(view, [propose_mask(view, view.surfaces.wall_masks[0] & ~picture, 0.9, tv=0.4)])
    assert not wall.flat, "what is a whole wall hangs on none"


def test_a_row_of_cabinets_is_several() -> None:
    boxes = [((3.6, -1.2 + 0.8 * k, 1.5), (4.0, -0.41 + 0.8 * k, 2.2)) for k in range(3)]
    view, cabinets = see_room(*boxes)
    row = np.any(cabinets, axis=0)
    things = choose(view, [propose_mask(view, row, 0.99), *(propose_mask(view, one, 0.9) for one in cabinets)])
    assert len(things) == 3 and all(max(iou(t.mask, c) for t in things) > 0.85 for c in cabinets)


def test_a_cupboard_of_two_doors_is_one() -> None:
    doors = [((3.4, -0.4 + 0.4 * k, 0.0), (4.0, 0.4 * k, 1.9)) for k in range(2)]
    view, parts = see_room(*doors)
    things = choose(view, [propose_mask(view, parts[0] | parts[1]), *(propose_mask(view, one) for one in parts)])
    assert len(things) == 1 and iou(things[0].mask, parts[0] | parts[1]) > 0.9


def test_a_frame_around_the_picture_shows_nothing() -> None:
    rgb = np.full((120, 160, 3), 90, np.uint8)
    rgb[50:70, :40] = 0  # a dark thing at the edge
    assert not find_border(rgb).any()
    rgb[:7] = rgb[:, -5:] = 0
    border = find_border(rgb)
    assert border[:7].all() and border[:, -5:].all() and not border[7:, :-5].any()


def test_clicks_lie_apart_in_what_is_left() -> None:
    rest = np.zeros((100, 120), dtype=bool)
    rest[10:50, 10:50] = rest[60:90, 70:110] = True
    clicks = choose_clicks(rest, 2)
    assert {(x > 60) for x, _ in clicks} == {True, False} and all(rest[y, x] for x, y in clicks)
    assert choose_clicks(np.zeros_like(rest), 3) == []


def test_what_stands_on_a_table_takes_nothing_from_a_thing_beside_it() -> None:
    """Its outline reaches over a bottle that is chosen already."""
    view, (table, mug, bottle) = see_room(TABLE, ON_TABLE, ((2.45, 0.06, 0.72), (2.55, 0.16, 0.98)))
    wide = mug | (bottle & (np.arange(bottle.shape[0])[:, None] > np.nonzero(bottle)[0].max() - 6))
    whole = propose_mask(view, table | mug, **{"dining table": 0.8})
    things = Chooser(view).choose([whole, propose_mask(view, bottle, bottle=0.9), propose_mask(view, wide)])
    assert len(things) == 3
    assert sum(one.mask.astype(int) for one in things).max() == 1


def test_a_flat_thing_is_crisp_and_has_wall_around() -> None:
    view, (picture,) = see_room(((3.96, -0.5, 1.2), (4.0, 0.3, 1.8)))
    assert choose(view, [propose_mask(view, picture, 0.9)]) == []
    view, _ = see_room(((3.4, -1.2, 0.0), (4.0, -0.2, 2.6)), ((3.4, 0.2, 0.0), (4.0, 1.2, 2.6)))
    between = view.surfaces.wall_masks[0] & (np.abs(view.surfaces.points[..., 1]) < 0.25)
    assert between.sum() > 1000 and choose(view, [propose_mask(view, between, 0.99)]) == []


def test_the_ground_is_no_table_and_half_a_picture_no_thing() -> None:
    view, (front,) = see_room(((2.2, -0.9, 0.0), (2.6, 0.9, 1.9)))
    assert front.mean() > 0.4 and choose(view, [propose_mask(view, front)]) == []
    view, _ = see_room(TABLE)
    assert choose(view, [propose_mask(view, view.surfaces.ground, **{"dining table": 0.9})]) == []


def test_what_is_seen_far_behind_a_chair_is_no_part_of_it() -> None:
    view, (chair, behind) = see_room(((2.0, -0.3, 0.0), (2.4, 0.3, 0.5)), ((3.3, -0.15, 0.6), (3.5, 0.15, 0.8)))
    wide = propose_mask(view, chair | behind, chair=0.9)
    own = propose_mask(view, chair)
    things = choose(view, [type(own)(own.logits, 0.9, "test", wide.words, wide.box), propose_mask(view, behind)])
    assert len(things) == 2


def test_pieces_are_cut_where_depth_jumps_and_at_hollows() -> None:
    chest, box, beside = (
        ((1.6, -0.6, 0.0), (2.0, 0.3, 0.6)),
        ((1.8, -0.3, 0.6), (2.0, 0.1, 1.0)),
        ((1.8, 0.5, 0.0), (2.1, 0.9, 0.5)),
    )
    view, (chest, box, beside) = see_room(chest, box, beside)
    outlines = [(one.score, one.mask) for one in pieces.propose(view, SeeSection())]
    for wanted, score in ((chest | box, pieces.WHOLE), (beside, pieces.WHOLE), (box, pieces.CUT)):
        assert max(iou(view.shrink(wanted), mask) for found, mask in outlines if found == score) > 0.75
    assert not any((mask & view.shrink(view.surfaces.floor)).sum() > 40 for _, mask in outlines)
