"""Where doors and drawers lie: as an asset's joints tell, and how far a model is from what was said."""

import numpy as np
import pytest
from pydantic import ValidationError

from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.library import FrontPanel, LibraryEntry
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.contracts.parts import Panel
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.matching.candidates import (
    Candidates,
    layout_gap,
    list_addends,
    measure_overlaps,
    panel_gap,
    to_boxes,
)


def panel(kind: str, left: float, right: float, bottom: float, top: float) -> Panel:
    return Panel.model_validate({"kind": kind, "left": left, "right": right, "bottom": bottom, "top": top})


def row(kind: str, count: int, bottom: float = 0.0, top: float = 1.0) -> list[Panel]:
    """Some panels side by side."""
    return [panel(kind, k / count, (k + 1) / count, bottom, top) for k in range(count)]


def stack(count: int) -> list[Panel]:
    """Some drawers one above the other."""
    return [panel("drawer", 0, 1, k / count, (k + 1) / count) for k in range(count)]


def entry(name: str, panels: list[Panel], doors: int, drawers: int) -> LibraryEntry:
    about = {"id": name, "category": "cabinet", "archive": "a.zip", "checksum": "c"}
    return LibraryEntry(**about, doors=doors, drawers=drawers, panels=panels)


def cabinet(panels: list[Panel], doors: int, drawers: int) -> SceneObject:
    told = {"articulated": True, "doors": doors, "drawers": drawers, "panels": panels}
    return SceneObject(id="cabinet_1", label="cabinet", mask=1, status="failed", reason="-", **told)


def test_what_lies_where_it_is_said_to_is_no_gap() -> None:
    said = [*row("drawer", 2, 0.7, 1.0), *row("door", 2, 0.0, 0.7)]
    assert layout_gap(said, said[::-1]) == pytest.approx(0)
    moved = [panel("drawer", 0.0, 0.5, 0.7, 1.0), panel("drawer", 0.55, 1.0, 0.7, 1.0), *row("door", 2, 0.0, 0.7)]
    beside = [panel(one.kind, one.left, 0.9 * one.right, one.bottom, 0.95 * one.top) for one in row("drawer", 1)]
    assert layout_gap(row("drawer", 1), beside) == pytest.approx(0)  # as far as boxes of things err
    assert layout_gap(row("drawer", 1), [panel("drawer", 0, 1, 0, 0.5)]) == pytest.approx(0.4)
    assert 0 < layout_gap(said, moved) == pytest.approx(1 - 0.45 / 0.5)
    assert layout_gap(said, row("drawer", 2, 0.7, 1.0)) == pytest.approx(2)  # two doors are missing
    assert layout_gap(row("door", 1), row("drawer", 1)) == pytest.approx(2)  # the same place, another kind


def test_pairs_are_those_that_leave_the_least_gap() -> None:
    """The nearest pair alone would leave the two others without any overlap."""
    ends = panel("drawer", 0, 0.05, 0, 1), panel("drawer", 0.95, 1, 0, 1)  # both outlines are those of the front
    said = [*ends, panel("drawer", 0.1, 0.5, 0, 1), panel("drawer", 0.3, 0.7, 0, 1)]
    own = [*ends, panel("drawer", 0.25, 0.65, 0, 1), panel("drawer", 0.5, 0.9, 0, 1)]
    apart = 1 - measure_overlaps(to_boxes(said), to_boxes(own))[2:, 2:]
    assert apart.argmin() == 2 and layout_gap(said, own) == pytest.approx(apart[0, 0] + apart[1, 1])
    assert apart[0, 0] + apart[1, 1] < apart[0, 1] + apart[1, 0]


def test_of_models_with_the_same_counts_the_one_with_the_layout_is_nearer() -> None:
    item = cabinet(stack(4), 0, 4)
    stacked, side, fewer = entry("a", stack(4), 0, 4), entry("b", row("drawer", 4), 0, 4), entry("c", stack(3), 0, 3)
    assert panel_gap(item, stacked) < 1e-9 < panel_gap(item, fewer) < panel_gap(item, side)
    options = MatchingConfig(count_weight=0.1)
    near, far = list_addends(item, Candidates([stacked, side], [], ""), options)
    assert near["counts"] == pytest.approx(0) and far["counts"] == pytest.approx(0.1 * panel_gap(item, side))


def test_counts_alone_count_as_they_do_without_boxes() -> None:
    assert panel_gap(cabinet([], 1, 3), entry("a", stack(4), 0, 4)) == 2
    assert panel_gap(cabinet(stack(4), 0, 4), entry("a", [], 2, 2)) == 4  # of a library that says no places
    assert panel_gap(cabinet(stack(4), 0, 4), entry("a", [], 0, 0)) == 4


def test_a_joint_s_panel_is_a_share_of_the_front() -> None:
    front = FrontPanel(hinge="slide", across=0.2, height=0.75, size=(0.4, 0.4))
    assert front.measure_on_front("drawer", (0.5, 0.8, 1.0)) == panel("drawer", 0, 0.5, 0.55, 0.95)
    wide = FrontPanel(hinge="slide", across=0.4, height=0.5, size=(0.82, 0.5))  # a lip at both sides
    assert wide.measure_on_front("drawer", (0.5, 0.8, 1.0)) == panel("drawer", 0, 1, 0.25, 0.75)
    assert FrontPanel(hinge="slide", height=0.5, size=(0.8, 0.5)).measure_on_front("drawer", (0.5, 0.8, 1.0)) is None
    beside = FrontPanel(hinge="left", across=0.9, height=0.5, size=(0.02, 0.5))
    assert beside.measure_on_front("door", (0.5, 0.8, 1.0)) is None


def test_boxes_and_counts_agree() -> None:
    with pytest.raises(ValidationError, match="left < right"):
        panel("door", 0.5, 0.5, 0, 1)
    for said in (
        lambda: Annotation(mask=1, label="cabinet", articulated=True, drawers=3, panels=stack(4)),
        lambda: Correction(mask=1, doors=1, panels=stack(4)),
    ):
        with pytest.raises(ValidationError, match="of its panels are"):
            said()
    assert Correction(mask=1, panels=stack(4)).drawers is None  # as many as there are boxes
    assert np.isclose(layout_gap([], stack(2)), 2)


@pytest.mark.parametrize(
    "half", [(0, 1, 0, 0.5), (0, 1, 0.5, 1), (0, 0.5, 0, 1), (0.5, 1, 0, 1)], ids=["lower", "upper", "left", "right"]
)
def test_a_panel_on_half_of_the_front_is_moved_by_a_tenth_at_most(half: tuple[float, float, float, float]) -> None:
    assert layout_gap(row("drawer", 1), [panel("drawer", *half)]) == pytest.approx(0.4)
