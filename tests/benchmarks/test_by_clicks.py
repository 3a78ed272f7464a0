"""Clicks until a picture's things are as if drawn by hand: the rule, on squares."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from benchmarks.open_rooms import by_clicks, pairs, tables
from benchmarks.open_rooms.by_clicks import BOX, DELETE, Effort
from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.hand import Corrections
from roomkin.stages.contracts.scenes import Annotation
from tests.benchmarks.test_open_rooms import TRUE, row

LEFT, RIGHT, BOTH = np.s_[20:60, 10:50], np.s_[20:60, 60:100], np.s_[20:60, 10:100]
SHAPE = (80, 120)


def thing(number: int = 1, kind: str = "desk", **said: Any) -> TrueThing:
    return TrueThing(**(vars(TRUE) | {"number": number, "kind": kind, "label": f"my {kind}"} | said))


def piece(value: int, *proposals: str, sure: bool = False) -> Annotation:
    doubts = [] if sure else [DoubtKind.NAME.of(name=proposals[0], share=40, others="b or c")]
    return Annotation(mask=value, label=proposals[0], proposals=list(proposals), doubts=doubts)


def paint(**areas: Any) -> NDArray[np.uint16]:
    """Masks; areas: by the value after a letter."""
    masks = np.zeros(SHAPE, dtype=np.uint16)
    for name, area in areas.items():
        masks[area] = int(name[1:])
    return masks


def cut_box(box: tuple[int, int, int, int]) -> NDArray[np.bool_]:
    """All of a box."""
    shown = np.zeros(SHAPE, dtype=bool)
    shown[box[1] : box[3], box[0] : box[2]] = True
    return shown


def plan(things: list[TrueThing], exact: Any, found: Any, *pieces: Annotation) -> list[by_clicks.Step]:
    placed = {item.mask for item in pieces}
    steps = by_clicks.plan_steps(things, exact, found, pieces, placed, cut_box)
    told = Corrections(objects=[step.correction for step in steps if step.correction is not None])
    assert len(told.objects) == sum(step.unaided != Effort() for step in steps)  # what is done is told, nothing else is
    return steps


@pytest.mark.parametrize(
    ("item", "how", "effort"),
    [
        (piece(7, "desk", "table", "bed"), "first", Effort()),
        (piece(7, "bed", "desk", "sofa"), "chosen", Effort(1)),
        (piece(7, "bed", "mug", "sofa"), "typed", Effort(1, 1)),
        (piece(7, "bed", "desk", sure=True), "chosen", Effort(2)),
        (piece(7, "bed", sure=True), "typed", Effort(2, 1)),
    ],
)
def test_a_name_costs_what_the_page_asks_for(item: Annotation, how: str, effort: Effort) -> None:
    (step,) = plan([thing()], paint(_1=LEFT), paint(_7=LEFT), item)
    assert (step.mask, step.name, step.value, step.unaided) == ("found", how, 7, effort)
    assert step.by_hand == Effort(BOX, 1)
    label = None if step.correction is None else step.correction.label
    assert label == {"first": None, "chosen": "desk", "typed": "my desk"}[how]


def test_what_is_missing_is_drawn_as_by_hand() -> None:
    (step,) = plan([thing(doors=2, drawers=3)], paint(_1=LEFT), paint())
    assert (step.mask, step.name) == ("drawn", "typed") and step.unaided == step.by_hand == Effort(BOX + 2, 3)
    assert step.correction is not None and step.correction.around == ((10, 20), (50, 60))
    assert (step.correction.doors, step.correction.drawers, step.correction.label) == (2, 3, "my desk")


def test_what_no_box_cuts_out_takes_an_outline() -> None:
    corner = paint(_1=BOTH)
    corner[20:50, 20:100] = 0  # an L, much of whose box is something else
    (step,) = plan([thing()], corner, paint())
    assert step.correction is not None and step.correction.around is None
    assert step.by_hand.clicks == len(step.correction.outline) + 2 == 6 + 2


def test_two_pieces_of_a_thing_are_joined() -> None:
    whole, halves = paint(_1=BOTH), paint(_7=np.s_[20:60, 10:55], _8=np.s_[20:60, 55:100])
    (step,) = plan([thing()], whole, halves, piece(7, "desk"), piece(8, "bed"))
    assert (step.mask, step.name, step.unaided) == ("joined", "first", Effort(3))
    assert step.correction is not None and step.correction.joins == [8 if step.value == 7 else 7]


def test_a_piece_that_is_no_thing_is_deleted_if_it_became_an_object() -> None:
    exact, found = paint(_1=LEFT), paint(_7=LEFT, _8=RIGHT)
    steps = plan([thing()], exact, found, piece(7, "desk"), piece(8, "bed"))
    assert [(step.number, step.mask, step.unaided.clicks) for step in steps] == [
        (1, "found", 0),
        (0, "deleted", DELETE),
    ]
    assert steps[1].correction is not None and steps[1].correction.gone and steps[1].by_hand == Effort()
    pieces = [piece(7, "desk"), piece(8, "bed")]
    assert len(by_clicks.plan_steps([thing()], exact, found, pieces, {7}, cut_box)) == 1


def test_one_piece_over_two_things_shows_neither() -> None:
    steps = plan([thing(1), thing(2)], paint(_1=LEFT, _2=RIGHT), paint(_7=BOTH), piece(7, "desk"))
    assert [step.mask for step in steps] == ["drawn", "drawn", "deleted"]


def test_doors_of_a_found_thing_are_counted_after_a_click_on_it() -> None:
    (step,) = plan([thing(kind="base_cabinet", doors=2)], paint(_1=LEFT), paint(_7=LEFT), piece(7, "bottom cabinet"))
    assert step.unaided == Effort(2, 1) and step.correction is not None and step.correction.doors == 2


def test_a_piece_shows_a_thing_from_more_than_half_on() -> None:
    iou, inside = pairs.overlaps(paint(_1=BOTH, _2=np.s_[0:10, 0:10]), paint(_3=LEFT, _4=np.s_[0:10, 0:10]))
    assert iou[1, 3] == pytest.approx(40 / 90) and inside[1, 3] == 1 and iou[2, 4] == 1
    assert pairs.pair_pieces([1, 2], iou) == {2: 4}
    assert pairs.pair_pieces([1], pairs.overlaps(paint(_1=BOTH), paint())[0]) == {}


def test_the_page_says_what_correcting_takes_beside_drawing() -> None:
    step = {"half": "work", "picture": "a", "number": 1, "kind": "desk", "mask": "found", "name": "chosen"}
    step |= {"clicks": 1, "words": 0, "clicks_by_hand": 3, "words_by_hand": 1}
    missing = step | {"number": 2, "mask": "drawn", "name": "typed", "clicks": 3, "words": 1}
    stray = step | {"number": 0, "mask": "deleted", "name": "", "clicks": 2, "clicks_by_hand": 0, "words_by_hand": 0}
    steps = pd.DataFrame([step, missing, stray, step | {"picture": "b", "name": "first", "clicks": 0}])
    page = tables.page(pd.DataFrame([row(1), row(2)]).assign(version="this"), steps)
    assert "| corrected | 3 (0 to 6) | 0 (0 to 1) |" in page and "| by hand | 4 (3 to 6) | 2 (1 to 2) |" in page
    assert "Fewer clicks than by hand in 1 of 2 pictures." in page
    assert "Of 3 things one piece shows 2, several 0, none 1." in page
    assert "right at first 1, one of the other two 1, typed 0. Pieces that are no named thing, deleted: 1." in page
