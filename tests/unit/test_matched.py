"""Corrections belong to a picture and to a place in it, whatever number the outline there has."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.contracts.files import write_json
from roomkin.stages.contracts.hand import Correction, Corrections, read_corrections
from roomkin.stages.contracts.matched import digest_masks, match_corrections, show_masks
from roomkin.stages.contracts.scenes import Held

Masks = NDArray[np.uint16]
PICTURE, OTHER = "a" * 64, "b" * 64
LABELS = {1: "cabinet", 2: "table", 3: "wall", 4: "mug"}


def draw(**boxes: tuple[int, int, int, int]) -> Masks:
    """Masks (60, 80) of boxes x0, y0, x1, y1 by value, e.g. m1=(...)."""
    masks = np.zeros((60, 80), np.uint16)
    for name, (x0, y0, x1, y1) in boxes.items():
        masks[y0:y1, x0:x1] = int(name[1:])
    return masks


BEFORE = draw(m3=(0, 0, 80, 20), m1=(2, 10, 22, 50), m2=(30, 30, 60, 55), m4=(40, 22, 46, 30))


def say(*items: Correction, masks: Masks = BEFORE, **more: Any) -> Corrections:
    """What the page writes."""
    named = {mask for item in items for mask in item.named_masks}
    about = {"digest": PICTURE, "size": masks.shape[::-1], "masks": digest_masks(masks)}
    shown = show_masks(named, masks, LABELS)
    return Corrections.model_validate({**about, "shown": shown, "objects": items, **more})


def renumber(masks: Masks, **to: int) -> Masks:
    found = np.zeros_like(masks)
    for name, value in to.items():
        found[masks == int(name[1:])] = value
    return found


def test_a_correction_follows_its_thing_when_masks_are_found_anew() -> None:
    said = say(
        Correction(mask=1, label="piano", mounting=Held(type=3, walls=[3])),
        Correction(mask=4, on=2, like=2),
        Correction(mask=2, gone=True),
    )
    now = renumber(BEFORE, m1=2, m2=4, m3=9, m4=1)
    now[40:45, 30:33] = 0  # and not quite the same
    matched = match_corrections(said, now, PICTURE)
    assert matched.corrections == {
        2: Correction(mask=2, label="piano", mounting=Held(type=3, walls=[9])),
        1: Correction(mask=1, on=4, like=4),
        4: Correction(mask=4, gone=True),
    }
    assert matched.unmatched == [] and matched.lines == []


@pytest.mark.parametrize("given", [
    {"label": "piano"}, {"gone": True}, {"size": (1.0, 1.0, 1.0)}, {"nudge": (0.1, 0.0)}, {"model": "cabinet_7"},
    {"banned": ["cabinet_7"]}, {"front": 0.5}, {"doors": 2}, {"mounting": "measured"}, {"on": "floor"}, {"layer": 2},
    {"like": 2}, {"joins": [4]}, {"articulated": True}, {"named": True},
])  # fmt: skip
def test_what_is_said_of_a_thing_that_is_gone_is_kept_told_and_applied_to_nothing(given: dict[str, Any]) -> None:
    item = Correction.model_validate({"mask": 1, **given})
    now = draw(m1=(30, 30, 60, 55), m2=(60, 0, 80, 9), m4=(40, 22, 46, 30))  # the table has the cabinet's number
    matched = match_corrections(say(item), now, PICTURE)
    assert matched.corrections == {}
    assert [one.correction for one in matched.unmatched] == [item]
    (line,) = matched.lines
    assert "cabinet" in line and "(mask 1): it is not found now: that correction is kept, not applied" in line
    again = Corrections(digest=PICTURE, size=(80, 60), masks=digest_masks(now), unmatched=matched.unmatched)
    back = match_corrections(again, renumber(BEFORE, m1=7, m2=2, m4=4), PICTURE)
    assert list(back.corrections) == [7] and back.lines == [], "and it comes back with its thing"


@pytest.mark.parametrize(("given", "word"), [
    ({"on": 2}, "what it stands on"), ({"like": 2}, "what it is like"), ({"joins": [4]}, "a part of it"),
    ({"mounting": Held(type=1, walls=[3])}, "its wall"),
])  # fmt: skip
def test_a_part_that_names_what_is_gone_is_kept_and_the_rest_applied(given: dict[str, Any], word: str) -> None:
    said = say(Correction.model_validate({"mask": 1, "label": "piano", **given}))
    matched = match_corrections(said, renumber(BEFORE, m1=5), PICTURE)
    assert matched.corrections == {5: Correction(mask=5, label="piano")}
    assert [one.correction for one in matched.unmatched] == [Correction.model_validate({"mask": 1, **given})]
    assert matched.lines == [
        f"'piano', found as 'cabinet' (mask 1): {word} is not found now: that correction is kept, not applied"
    ]
    state = say(*matched.corrections.values(), masks=renumber(BEFORE, m1=5), unmatched=matched.unmatched)
    back = match_corrections(state, renumber(BEFORE, m1=6, m2=2, m3=3, m4=4), PICTURE)
    assert back.corrections == {6: Correction.model_validate({"mask": 6, "label": "piano", **given})}
    assert back.unmatched == []


def test_a_poor_partner_is_none() -> None:
    said = say(Correction(mask=1, label="piano"))
    half, most = draw(m1=(2, 10, 22, 29)), draw(m1=(2, 10, 22, 33))  # 19 and 23 of 40 rows
    assert match_corrections(said, half, PICTURE).corrections == {}
    assert list(match_corrections(said, most, PICTURE).corrections) == [1]


def test_what_was_said_since_counts() -> None:
    empty, before = draw(m9=(60, 0, 80, 9)), say(Correction(mask=1, label="piano", front=1.0))
    since = say(Correction(mask=1, label="organ"), unmatched=match_corrections(before, empty, PICTURE).unmatched)
    assert match_corrections(since, BEFORE, PICTURE).corrections == {1: Correction(mask=1, label="organ", front=1.0)}
    before = say(Correction(mask=1, like=2))
    against = say(Correction(mask=2, like=1), unmatched=match_corrections(before, empty, PICTURE).unmatched)
    matched = match_corrections(against, BEFORE, PICTURE)
    assert matched.corrections == {2: Correction(mask=2, like=1)} and len(matched.lines) == 1, "no circle"


def test_what_was_drawn_keeps_its_outline() -> None:
    """In the place of what is found there now, under a number that is free, with what stands on it."""
    vase = [(64.0, 30.0), (74.0, 30.0), (74.0, 50.0), (64.0, 50.0)]
    said = say(
        Correction(mask=5, label="vase", outline=vase),
        Correction(mask=4, on=5),
        Correction(mask=6, label="box", around=((62.0, 2.0), (72.0, 12.0))),
    )
    elsewhere = renumber(BEFORE, m2=5, m4=6)
    matched = match_corrections(said, elsewhere, PICTURE)
    assert {item.label: mask for mask, item in matched.corrections.items()} == {"vase": 7, None: 6, "box": 8}
    assert matched.corrections[6] == Correction(mask=6, on=7) and matched.lines == []
    found = elsewhere.copy()
    found[31:50, 64:74] = 2
    assert match_corrections(said, found, PICTURE).corrections[2] == Correction(mask=2, label="vase", outline=vase)
    redrawn = say(Correction(mask=1, outline=vase, label="vase"))
    assert list(match_corrections(redrawn, draw(m1=(0, 0, 9, 9)), PICTURE).corrections) == [2], "its mask is gone"


def test_of_two_things_drawn_at_one_place_one_is_what_is_found_there() -> None:
    box = [(30.0, 30.0), (60.0, 30.0), (60.0, 55.0), (30.0, 55.0)]
    said = say(Correction(mask=5, label="cover", outline=box), Correction(mask=6, label="rug", outline=box))
    found = match_corrections(said, renumber(BEFORE, m2=7), PICTURE).corrections
    assert {mask: item.label for mask, item in found.items()} == {7: "cover", 6: "rug"}


def test_of_a_correction_that_is_lost_whole_in_its_part_nothing_is_applied() -> None:
    matched = match_corrections(say(Correction(mask=1, on=2)), renumber(BEFORE, m1=5), PICTURE)
    assert matched.corrections == {} and len(matched.unmatched) == 1


def test_numbers_count_as_long_as_the_masks_are_the_same() -> None:
    """Also of a thing drawn over another one, and in a file written by hand, as far as its numbers are there."""
    over = Correction(mask=8, label="cover", outline=[(30.0, 30.0), (60.0, 30.0), (60.0, 55.0), (30.0, 55.0)])
    assert match_corrections(say(over), BEFORE, PICTURE).corrections == {8: over}
    by_hand = Corrections(objects=[Correction(mask=1, label="piano"), Correction(mask=9, label="lamp"), over])
    matched = match_corrections(by_hand, BEFORE, PICTURE)
    assert set(matched.corrections) == {1, 8}
    assert matched.lines == ["lamp (mask 9): it is not found now: that correction is kept, not applied"]


def test_another_picture_is_told_and_the_same_at_another_size_is_not_another() -> None:
    vase = Correction(mask=5, label="vase", outline=[(64.0, 30.0), (74.0, 30.0), (74.0, 50.0), (64.0, 50.0)])
    said = say(Correction(mask=1, label="piano"), vase)
    matched = match_corrections(said, BEFORE, OTHER)
    assert matched.corrections == {} and len(matched.lines) == 1 and "of another picture" in matched.lines[0]
    twice = np.kron(renumber(BEFORE, m1=3, m2=2), np.ones((2, 2), np.uint16))
    found = match_corrections(said, twice, PICTURE).corrections
    assert found[3] == Correction(mask=3, label="piano") and found[5].outline[2] == (148.0, 100.0)


def test_each_stage_reads_its_own_part_and_the_file_comes_back_whole(tmp_path: Path) -> None:
    unmatched = match_corrections(
        say(Correction(mask=1, label="piano", nudge=(0.1, 0.0))), draw(m9=(0, 0, 9, 9)), PICTURE
    )
    said = say(
        Correction(mask=2, nudge=(0.2, 0.0), on=3), Correction(mask=4, label="cup"), unmatched=unmatched.unmatched
    )
    write_json(tmp_path / "corrections.json", said)
    read = read_corrections([tmp_path / "corrections.json"])
    assert read == said
    extraction, generation = read.read_by("extraction"), read.read_by("generation")
    assert [item.mask for item in extraction.objects] == [2, 4] and [item.mask for item in generation.objects] == [2]
    assert extraction.unmatched[0].correction == Correction(mask=1, label="piano")
    assert generation.unmatched[0].correction == Correction(mask=1, nudge=(0.1, 0.0))
    assert {one.mask for one in extraction.shown} == {2, 3, 4} and {one.mask for one in generation.shown} == {2}
    assert json.loads(generation.model_dump_json())["masks"] == digest_masks(BEFORE)


@pytest.mark.parametrize("seed", range(20))
def test_nothing_is_ever_applied_to_something_else(seed: int) -> None:
    """Rooms whose things are found anew: renumbered, shrunk, merged, cut in two, lost, and new ones."""
    rng = np.random.default_rng(seed)
    before = np.zeros((120, 160), np.uint16)
    for value in range(1, 13):
        x, y, w, h = rng.integers([0, 0, 12, 12], [130, 95, 40, 40])
        before[y : y + h, x : x + w] = value
    values = [int(value) for value in np.unique(before) if value]
    said = say(*(Correction(mask=value, label=f"thing {value}") for value in values), masks=before)
    after = np.zeros_like(before)
    for new, value in zip(rng.permutation(np.arange(1, 30)), values, strict=False):
        kind, inside = rng.integers(4), before == value
        if kind == 0:
            continue  # lost
        if kind == 1:
            inside &= rng.random(before.shape) < rng.uniform(0.3, 1)
        if kind == 2:
            inside[:, : int(np.median(np.nonzero(inside)[1]))] = False
        after[inside] = new
    after[rng.integers(100) :, rng.integers(140) :] = 31
    matched = match_corrections(said, after, PICTURE)
    for mask, item in matched.corrections.items():
        was, now = before == int((item.label or "").split()[1]), after == mask
        assert (was & now).sum() > 0.5 * now.sum() or (was & now).sum() > 0.5 * was.sum()
    kept = [one.correction.label for one in matched.unmatched]
    assert sorted([*kept, *(item.label for item in matched.corrections.values())]) == sorted(
        f"thing {value}" for value in values
    )
    assert len(matched.lines) == len(kept)
