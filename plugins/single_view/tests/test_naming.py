"""What outlines are called that no network knows: by where they stand and how large that makes them."""

from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from plugins.names.propose import Names, Proposal
from plugins.single_view.naming import join_stacked, name_outlines
from plugins.single_view.room import Room, build_room
from plugins.single_view.tests.room import BOXES, HEIGHT, LABELS, WIDTH, outline_box, outline_room, see_lines, show_room
from plugins.single_view.things import Seen, number_masks
from stages.contracts.categories import known_categories
from stages.geometry.boxes import UprightBox

Mask = NDArray[np.bool_]
ALIKE = [Proposal(name.replace("_", " "), 0.3 / len(known_categories())) for name in known_categories()]
NOBODY_KNOWS = Names(ALIKE, 0.7)


def unknown(mask: Mask, score: float = 0.95) -> Seen:
    return Seen(mask, score, NOBODY_KNOWS, False)


def known(mask: Mask, *names: tuple[str, float]) -> Seen:
    return Seen(mask, 0.95, Names([Proposal(*one) for one in names], 0.05), True)


def see(*further: Mask, beside: Sequence[int] = (1, 2)) -> tuple[list[Seen], Room, dict[int, str]]:
    """Outlines of a fridge and a sofa that are known, and further ones."""
    masks = outline_room(tuple(beside))
    seen = [known(masks == value, (LABELS[value], 0.9)) for value in beside] + [unknown(mask) for mask in further]
    labels = {number: LABELS[value] for number, value in enumerate(beside, 1)}
    things = {number: seen[number - 1] for number in labels}
    return seen, build_room(show_room(), see_lines(), number_masks(show_room(), things), labels), labels


def floor_around(*masks: Mask) -> Mask:
    floor = np.zeros((HEIGHT, WIDTH), bool)
    floor[HEIGHT // 2 :] = True
    return floor & ~np.any([*masks], axis=0)


def test_a_known_thing_is_one_of_the_library_or_none() -> None:
    mask = outline_box(BOXES[1])
    assert known(mask, ("fridge", 0.9)).is_sure
    assert not Seen(mask, 0.95, Names([Proposal("fridge", 0.3)], 0.7), True).is_sure, "it is likelier none"
    assert not Seen(mask, 0.95, Names([Proposal("fridge", 0.9)], 0.1), False).is_sure, "no network knows it"


def test_a_row_of_drawers_over_a_door_is_one_front() -> None:
    masks = np.zeros((3, HEIGHT, WIDTH), bool)
    masks[0, 200:300, 100:200], masks[1, 150:198, 102:199], masks[2, 100:148, 100:300] = True, True, True
    joined = join_stacked(show_room(), [unknown(mask) for mask in masks], {})
    assert joined[0].mask.sum() == masks[0].sum() + masks[1].sum() and not joined[1].mask.any()
    assert (joined[2].mask == masks[2]).all(), "what is wider is another thing"
    kept = join_stacked(show_room(), [unknown(mask) for mask in masks], {1: "fridge"})
    assert (kept[1].mask == masks[1]).all(), "what stands on a known thing is a thing"


def test_what_stands_on_the_floor_is_named_by_its_size() -> None:
    low = UprightBox([-1.1, 4.1, 0.36], [1.0, 0.5, 0.72], 0.0)
    mask = outline_box(low) & (outline_room((1, 2)) == 0)
    masks = outline_room((1, 2))
    seen, room, labels = see(mask, floor_around(mask, masks > 0))
    _, found = name_outlines(show_room(), seen, room, labels)
    category = known_categories()[found[3].replace(" ", "_")]
    extents = np.exp(category.describe_spread()[0])  # type: ignore[index]
    assert extents[1] == pytest.approx(1.0, rel=0.6) and extents[2] == pytest.approx(0.72, rel=0.4)
    assert 4 not in found, "the floor is no thing"
    seen, room, labels = see(mask)
    assert name_outlines(show_room(), seen, room, labels)[1][3] == found[3], "also where no outline shows the floor"


def test_a_wall_down_to_the_floor_is_no_thing() -> None:
    masks = outline_room((1, 2))
    wall = np.zeros((HEIGHT, WIDTH), bool)
    wall[:280, 330:600] = True
    wall &= masks == 0
    seen, room, labels = see(wall, floor_around(wall, masks > 0))
    assert 3 not in name_outlines(show_room(), seen, room, labels)[1]


def test_an_upright_rectangle_high_on_a_wall_is_a_picture() -> None:
    seen, room, labels = see(outline_box(BOXES[5]))
    assert name_outlines(show_room(), seen, room, labels)[1][3] == "picture"
    blurred = [*seen[:2], unknown(seen[2].mask, 0.8)]
    assert 3 not in name_outlines(show_room(), blurred, room, labels)[1]
    middle = np.zeros((HEIGHT, WIDTH), np.uint8)
    y, x = np.argwhere(seen[2].mask).mean(axis=0).astype(int).tolist()
    large = cv2.rectangle(middle.copy(), (x - 130, y - 50), (x + 130, y + 40), 1, -1)
    for shape in (large, cv2.ellipse(middle.copy(), (x, y), (40, 30), 0, 0, 360, 1, -1), middle.copy()):
        if not shape.any():
            shape[y - 12 : y + 12, x - 12 : x + 12] = 1  # too small to tell
        seen, room, labels = see(shape > 0)
        assert 3 not in name_outlines(show_room(), seen, room, labels)[1]
    cut = np.zeros((HEIGHT, WIDTH), bool)
    cut[0:60, 300:400] = True
    seen, room, labels = see(cut)
    assert 3 not in name_outlines(show_room(), seen, room, labels)[1]


def test_what_carries_a_known_thing_is_one_of_those_that_do() -> None:
    masks = outline_room((1, 2, 3, 4))
    seen = [known(masks == value, (LABELS[value], 0.9)) for value in (1, 2, 4)] + [unknown(masks == 3)]
    labels = {1: "fridge", 2: "sofa", 3: "mug"}
    room = build_room(show_room(), see_lines(), number_masks(show_room(), {k: seen[k - 1] for k in labels}), labels)
    assert 3 not in room.boxes
    found = name_outlines(show_room(), seen, room, labels)[1]
    assert {"appliance", "storage", "table"} & set(known_categories()[found[4].replace(" ", "_")].kin)


def test_the_floor_below_a_fridge_carries_no_mug() -> None:
    masks = outline_room((1, 2))
    foot = int(np.nonzero(masks == 1)[0].max())
    column = int(np.nonzero(masks == 1)[1].max()) + 20
    mug = np.zeros((HEIGHT, WIDTH), bool)
    mug[foot - 20 : foot, column : column + 14] = True
    seen = [known(masks == 1, ("fridge", 0.9)), known(mug, ("mug", 0.9)), unknown(floor_around(mug, masks > 0))]
    labels = {1: "fridge", 2: "mug"}
    room = build_room(show_room(), see_lines(), number_masks(show_room(), {k: seen[k - 1] for k in labels}), labels)
    assert 3 not in name_outlines(show_room(), seen, room, labels)[1]


def test_size_chooses_among_the_likely_names_of_a_known_thing() -> None:
    masks = outline_room((1, 2))
    both = ("armchair", 0.5), ("sofa", 0.45)
    seen = [known(masks == 1, ("fridge", 0.9)), known(masks == 2, *both)]
    room = build_room(show_room(), see_lines(), masks, {1: "fridge", 2: "sofa"})
    assert name_outlines(show_room(), seen, room, {1: "fridge", 2: "armchair"})[1][2] == "sofa"
