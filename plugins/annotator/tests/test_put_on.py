"""What a person says that a thing stands on, and where it stands then."""

from dataclasses import replace

import pytest

from roomkin.stages.contracts.hand import Correction
from roomkin.stages.extraction.reconstruct import correct_scene
from roomkin.stages.geometry.boxes import UprightBox
from tests.unit.synthetic_room import OBJECT, trace
from tests.unit.test_inexact_masks import ends, extracted


def test_what_is_put_on_a_desk_stands_on_its_top() -> None:
    """The desk's mask shows a box, too, that stands on it."""
    desk, cup = (
        UprightBox([2.4, 0, 0.375], [0.7, 1.4, 0.75], 0.1),
        UprightBox([2.25, -0.3, 0.8], [0.09, 0.09, 0.1], 0.0),
    )
    depth, masks = trace([desk, cup, UprightBox([2.5, 0.4, 0.85], [0.25, 0.3, 0.2], 0.1)])
    masks[masks > OBJECT + 1] = OBJECT
    found = extracted(depth, masks, "desk", "cup")
    told = correct_scene(found, {OBJECT + 1: Correction(mask=OBJECT + 1, on=OBJECT)}).objects.objects[1]
    assert told.support == found.objects.objects[0].id and ends(told) == pytest.approx((0.75, 0.85), abs=0.02)


def test_what_was_stretched_to_the_floor_is_put_on_a_table_at_its_own_height() -> None:
    table, book = (
        UprightBox([2.4, 0, 0.225], [0.6, 1.0, 0.45], 0.0),
        UprightBox([2.35, 0, 0.47], [0.2, 0.25, 0.04], 0.2),
    )
    depth, masks = trace([table, book])
    found = extracted(depth, masks, "table", "book")
    item = found.objects.objects[1]
    assert item.box is not None
    column = item.box.model_copy(update={"center": (*item.box.center[:2], 0.245), "size": (*item.box.size[:2], 0.49)})
    items = [found.objects.objects[0], item.model_copy(update={"box": column, "measured_support": "floor"})]
    fallen = replace(found, objects=found.objects.model_copy(update={"objects": items}))
    told = correct_scene(fallen, {OBJECT + 1: Correction(mask=OBJECT + 1, on=OBJECT)}).objects.objects[1]
    assert ends(told) == pytest.approx((0.45, 0.49), abs=0.015)
