"""What outlines are called that no network knows: by where they stand, rest or hang and how large that makes them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.perception.camera.metrology import UprightPlane
from roomkin.stages.perception.classification import by_size
from roomkin.stages.perception.classification.by_size import expect_found, name_by_extents, name_others, name_standing
from roomkin.stages.perception.classification.names import LikelyName, Names
from roomkin.stages.perception.layout.ends import kind_of, measure_all, number_masks
from roomkin.stages.perception.layout.room import FittedRoom
from roomkin.stages.perception.layout.things import (
    FLOOR,
    HANGS,
    KINDS,
    NOTHING,
    RESTS,
    STANDS,
    WALL,
    OutlineCandidate,
    join_stacked,
    make_view,
)
from roomkin.stages.perception.segmentation.choosing import Outlined
from tests.unit.perception.room_alone import (
    BOXES,
    HEIGHT,
    LABELS,
    WIDTH,
    arrange_once,
    build_once,
    outline_box,
    outline_room,
    see_lines,
    show_room,
)

Mask = NDArray[np.bool_]
ALIKE = [LikelyName(name.replace("_", " "), 0.3 / len(known_categories())) for name in known_categories()]
NOBODY_KNOWS = Names(ALIKE, 0.7)


def likely(*kinds: str) -> NDArray[np.float64]:
    """Probabilities of kinds, the first the most."""
    return np.array([2.0 ** -kinds.index(kind) if kind in kinds else 0.0 for kind in KINDS])


def unknown(mask: Mask, kind: str) -> OutlineCandidate:
    return OutlineCandidate(mask, likely(kind), NOBODY_KNOWS, False)


def known(mask: Mask, *names: tuple[str, float]) -> OutlineCandidate:
    return OutlineCandidate(mask, likely(STANDS), Names([LikelyName(*one) for one in names], 0.05), True)


INSIDE = np.ones((HEIGHT, WIDTH), bool)


def see(
    *further: OutlineCandidate, beside: Sequence[int] = (1, 2)
) -> tuple[list[OutlineCandidate], FittedRoom, dict[int, str]]:
    """Outlines of a fridge and a sofa that are known, and further ones."""
    masks = outline_room(tuple(beside))
    seen = [known(masks == value, (LABELS[value], 0.9)) for value in beside] + list(further)
    labels = {number: LABELS[value] for number, value in enumerate(beside, 1)}
    return seen, build_once(show_room(), see_lines(), number(seen), labels), labels


def number(seen: Sequence[OutlineCandidate]) -> NDArray[np.uint16]:
    return number_masks({value: one.mask for value, one in enumerate(seen, 1)}, INSIDE.shape)


def first(named: dict[int, Names]) -> dict[int, str]:
    return {value: names.proposals[0].name for value, names in named.items()}


def name(seen: Sequence[OutlineCandidate], labels: dict[int, str]) -> tuple[dict[int, Names], set[int]]:
    masks = number(seen)
    arranged = arrange_once(show_room(), see_lines(), masks, labels)
    return name_standing(seen, masks, measure_all(masks, range(1, len(seen) + 1), INSIDE), arranged, labels, INSIDE)


def stand(seen: Sequence[OutlineCandidate], _: object, labels: dict[int, str]) -> dict[int, str]:
    return first(name(seen, labels)[0])


def name_rest(seen: Sequence[OutlineCandidate], room: FittedRoom, labels: dict[int, str]) -> dict[int, Names]:
    masks, kinds = number(seen), {value: kind_of(label) for value, label in labels.items()}
    return name_others(seen, masks, measure_all(masks, range(1, len(seen) + 1), INSIDE), room, kinds)


def rest(seen: Sequence[OutlineCandidate], room: FittedRoom, labels: dict[int, str]) -> dict[int, str]:
    return first(name_rest(seen, room, labels))


def kin_of(label: str) -> set[str]:
    return set(known_categories()[label.replace(" ", "_")].kin)


def floor_around(*masks: Mask) -> OutlineCandidate:
    floor = np.zeros((HEIGHT, WIDTH), bool)
    floor[HEIGHT // 2 :] = True
    return unknown(floor & ~np.any([*masks], axis=0), FLOOR)


def test_a_known_thing_is_one_of_the_library_or_none() -> None:
    mask = outline_box(BOXES[1])
    assert known(mask, ("fridge", 0.9)).is_sure
    assert not OutlineCandidate(mask, 0.95, Names([LikelyName("fridge", 0.3)], 0.7), True).is_sure, (
        "it is likelier none"
    )
    assert not OutlineCandidate(mask, 0.95, Names([LikelyName("fridge", 0.9)], 0.1), False).is_sure, (
        "no network knows it"
    )


def test_a_row_of_drawers_over_a_door_is_one_front() -> None:
    masks = np.zeros((3, HEIGHT, WIDTH), bool)
    masks[0, 200:300, 100:200], masks[1, 150:198, 102:199], masks[2, 100:148, 100:300] = True, True, True
    found = [Outlined(mask, 0.9, "mobile_sam", {}, False) for mask in masks]
    joined = join_stacked(make_view(show_room()), found, [STANDS, NOTHING, RESTS])
    assert [one.mask.sum() for one in joined] == [masks[0].sum() + masks[1].sum(), masks[2].sum()]
    assert (joined[1].mask == masks[2]).all(), "what is wider is another thing"
    nothing = Outlined(np.zeros_like(masks[0]), 0.9, "mobile_sam", {}, False)
    assert len(join_stacked(make_view(show_room()), [nothing, *found], [STANDS, STANDS, NOTHING, RESTS])) == 2
    aside = [Outlined(np.roll(masks[k], 30 * k, axis=1), 0.9, "mobile_sam", {}, False) for k in (0, 1)]
    assert len(join_stacked(make_view(show_room()), aside, [STANDS, NOTHING])) == 2, "so is what is not above it"
    on_known = [Outlined(masks[0], 0.9, "ssd", {"refrigerator": 0.9}, False), *found[1:]]
    assert len(join_stacked(make_view(show_room()), on_known, [STANDS, NOTHING, RESTS])) == 3, (
        "what stands on a known thing is one"
    )
    assert len(join_stacked(make_view(show_room()), found, [FLOOR, STANDS, RESTS])) == 3, (
        "the floor is no part of what it carries"
    )


def test_what_stands_on_the_floor_is_named_by_its_size() -> None:
    low = UprightBox([-1.1, 4.1, 0.36], [1.0, 0.5, 0.72], 0.0)
    masks = outline_room((1, 2))
    mask = outline_box(low) & (masks == 0)
    found = stand(*see(unknown(mask, STANDS), floor_around(mask, masks > 0)))
    category = known_categories()[found[3].replace(" ", "_")]
    extents = np.exp(category.measure_spread()[0])  # type: ignore[index]
    assert extents[1] == pytest.approx(1.0, rel=0.6) and extents[2] == pytest.approx(0.72, rel=0.4)
    assert 4 not in found, "the floor is no thing"
    assert stand(*see(unknown(mask, STANDS)))[3] == found[3], "also where no outline shows the floor"
    assert stand(*see(unknown(mask, STANDS), unknown(~mask & (masks == 0), WALL)))[3] == found[3], "walls hide nothing"
    for kind in (WALL, NOTHING, RESTS, HANGS):
        assert 3 not in stand(*see(unknown(mask, kind)))


def test_a_rug_ends_at_the_floor() -> None:
    flat = UprightBox([-0.6, 2.9, 0.01], [1.2, 0.6, 0.02], 0.0)
    mask = outline_box(flat)
    rug = OutlineCandidate(mask, likely(STANDS), Names([LikelyName("rug", 0.9)], 0.1), False)
    below = unknown(np.any([np.roll(mask, k, axis=0) for k in range(1, 40)], axis=0) & ~mask, NOTHING)
    assert stand(*see(rug))[3] == "rug"
    assert stand(*see(rug, below))[3] != "rug", "what ends at another thing is none"


def test_what_is_tiny_or_ends_at_the_horizon_is_left() -> None:
    tiny, high = np.zeros((2, HEIGHT, WIDTH), bool)
    tiny[400:420, 20:40], high[60:150, 500:600] = True, True
    assert not {3, 4} & set(stand(*see(unknown(tiny, STANDS), unknown(high, STANDS))))


def test_what_hangs_is_named_by_its_size_on_its_wall() -> None:
    seen, room, labels = see(unknown(outline_box(BOXES[5]), HANGS))
    assert rest(seen, room, labels) == {3: "picture"}
    wide = UprightBox([-0.2, 4.35, 0.5], [1.1, 0.1, 0.6], 0.0)
    radiator = OutlineCandidate(outline_box(wide), likely(HANGS), Names([LikelyName("radiator", 0.5)], 0.5), False)
    assert rest(*see(radiator)) == {3: "radiator"}, "by its looks, too"
    either = OutlineCandidate(outline_box(BOXES[5]), likely(RESTS, HANGS, WALL), NOBODY_KNOWS, False)
    assert rest(*see(either)) == {3: "picture"}, "as nothing carries it"


def test_a_wall_that_is_not_faced_tells_no_size() -> None:
    seen, room, labels = see(unknown(outline_box(BOXES[5]), HANGS))
    behind = replace(room, walls=[UprightPlane(np.array([0.0, 1.0, 0.0]), -1.0)])
    assert rest(seen, behind, labels) == {}


def test_the_distance_of_a_wall_is_less_sure_than_that_of_a_top() -> None:
    picture, size = unknown(outline_box(BOXES[5]), HANGS), np.array([1.5, 1.6])  # thrice as large as usual
    alike = {"picture": 1.0, "curtain": 0.2}
    assert name_by_extents(size, 0.6, picture, alike).proposals[0].name == "picture"
    assert name_by_extents(size, 0.0, picture, alike).proposals[0].name == "curtain"


def test_what_rests_above_the_camera_has_no_size() -> None:
    seen, room, labels = see(unknown(outline_room((1, 2, 3, 4)) == 4, RESTS), beside=(1, 2, 3))
    tall = UprightBox(np.add(room.boxes[3].center, [0, 0, 1.5]), room.boxes[3].size, 0.0)
    high = replace(room, boxes={**room.boxes, 3: tall})
    assert rest(seen, high, labels) == {}


def test_what_the_network_of_coco_knows_it_would_have_found() -> None:
    names = NOBODY_KNOWS.choose_among({"bottle": 1.0, "jar": 1.0}, expect_found())
    shares = {one.name: one.probability for one in names.proposals}
    assert shares["bottle"] < 0.5 * shares["jar"]


def test_what_rests_on_a_thing_is_named_by_its_size_there() -> None:
    masks = outline_room((1, 2, 3, 4))
    seen, room, labels = see(unknown(masks == 4, RESTS), beside=(1, 2, 3))
    seen[2] = known(masks == 3, ("coffee table", 0.9))
    label = rest(seen, room, labels)[4]
    height = float(np.exp(known_categories()[label.replace(" ", "_")].measure_spread()[0][2]))  # type: ignore[index]
    assert height < 0.3 and "top" in known_categories()[label.replace(" ", "_")].places
    aside = np.roll(masks == 4, 150, axis=1)
    assert rest([*seen[:3], unknown(aside, RESTS)], room, labels) == {}, "nothing carries it"


def test_no_name_is_of_a_category_that_is_never_in_such_a_place() -> None:
    def places(names: Names) -> list[list[str]]:
        return [known_categories()[one.category].places for one in names.proposals]

    masks = outline_room((1, 2, 3, 4))
    seen, room, labels = see(unknown(masks == 4, RESTS), unknown(outline_box(BOXES[5]), HANGS), beside=(1, 2, 3))
    found = name_rest(seen, room, labels)
    assert all("top" in one for one in places(found[4])) and all("wall" in one for one in places(found[5]))
    seen, _, labels = see(unknown(masks == 3, STANDS))
    assert all("floor" in one for one in places(name(seen, labels)[0][3]))


def test_what_carries_a_known_thing_is_one_of_those_that_do() -> None:
    masks = outline_room((1, 2, 3, 4))
    seen = [known(masks == value, (LABELS[value], 0.9)) for value in (1, 2, 4)] + [unknown(masks == 3, NOTHING)]
    labels = {1: "fridge", 2: "sofa", 3: "mug"}
    assert 3 not in arrange_once(show_room(), see_lines(), number(seen), labels).boxes
    assert {"appliance", "storage", "table"} & kin_of(stand(seen, None, labels)[4])
    assert name(seen, labels)[1] == {4}
    seen[3] = replace(seen[3], names=Names([LikelyName("ottoman", 0.99)], 0.01))
    assert {"appliance", "storage", "table"} & kin_of(stand(seen, None, labels)[4]), "whatever it looks like"


def test_the_floor_below_a_fridge_carries_no_mug() -> None:
    masks = outline_room((1, 2))
    foot = int(np.nonzero(masks == 1)[0].max())
    column = int(np.nonzero(masks == 1)[1].max()) + 20
    mug = np.zeros((HEIGHT, WIDTH), bool)
    mug[foot - 20 : foot, column : column + 14] = True
    seen = [known(masks == 1, ("fridge", 0.9)), known(mug, ("mug", 0.9)), floor_around(mug, masks > 0)]
    labels = {1: "fridge", 2: "mug"}
    assert 3 not in stand(seen, None, labels)


def test_size_chooses_among_the_likely_names_of_a_known_thing() -> None:
    masks = outline_room((1, 2))
    both = ("armchair", 0.5), ("sofa", 0.45)
    seen = [known(masks == 1, ("fridge", 0.9)), known(masks == 2, *both)]
    assert stand(seen, None, {1: "fridge", 2: "armchair"})[2] == "sofa"


def test_a_thing_whose_size_cannot_be_told_gets_no_name_and_others_do(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail_for_unknown(arranged: object, item: object, names: Sequence[str]) -> object:
        if len(names) > 10:
            raise np.linalg.LinAlgError("singular matrix")
        return weigh(arranged, item, names)  # type: ignore[arg-type]

    def fail_once(*given: object) -> object:
        calls.append(given)
        if len(calls) == 1:
            raise IndexError("index -1 is out of bounds")
        return tell(*given)  # type: ignore[arg-type]

    weigh, tell, calls = by_size.weigh_sizes, by_size.name_by_extents, list[object]()
    low = outline_box(UprightBox([-1.1, 4.1, 0.36], [1.0, 0.5, 0.72], 0.0)) & (outline_room((1, 2)) == 0)
    monkeypatch.setattr(by_size, "weigh_sizes", fail_for_unknown)
    assert set(stand(*see(unknown(low, STANDS)))) == {1, 2}
    monkeypatch.setattr(by_size, "name_by_extents", fail_once)
    picture = outline_box(BOXES[5])
    assert set(rest(*see(unknown(picture, HANGS), unknown(np.roll(picture, 80, axis=1), HANGS)))) == {4}


def test_what_is_likely_nothing_stays_so_but_on_a_wall() -> None:
    masks, doubted = outline_room((1, 2)), Names([LikelyName("desk", 0.1)], 0.9)
    low = outline_box(UprightBox([-1.1, 4.1, 0.36], [1.0, 0.5, 0.72], 0.0)) & (masks == 0)
    seen, _, labels = see(replace(unknown(low, STANDS), names=doubted), floor_around(low, masks > 0))
    assert name(seen, labels)[0][3].other == pytest.approx(0.9)
    on_table = outline_room((1, 2, 3, 4)) == 4
    rests = see(replace(unknown(on_table, RESTS), names=doubted), beside=(1, 2, 3))
    assert name_rest(*rests)[4].other == pytest.approx(0.9)
    hangs = see(replace(unknown(outline_box(BOXES[5]), HANGS), names=doubted))
    assert name_rest(*hangs)[3].other == 0, "looks tell pictures from walls too seldom"
