"""What masks leave out or show too much of: what carries an object, what a mirror shows."""

import numpy as np
import pytest
from numpy.typing import NDArray

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts import Annotations
from roomkin.stages.contracts.hand import Correction
from roomkin.stages.contracts.objects import USUAL_ERROR, Box, DepthError, SceneObject, Wall
from roomkin.stages.contracts.scenes import Annotation, Held
from roomkin.stages.extraction.contact import DepthView, measure_shelf
from roomkin.stages.extraction.corrected_masks import Cutter, correct_masks, paint_masks
from roomkin.stages.extraction.depth_error import remove_reflections
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.reconstruct import ExtractedScene, correct_image, find_hanging, reconstruct
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import PointMap
from roomkin.stages.geometry.masks import central_crop, erode
from tests.refusals import refused
from tests.unit.synthetic_room import (
    BACK_WALL,
    FLOOR,
    HEIGHT,
    INTRINSICS,
    OBJECT,
    WALL,
    WIDTH,
    WORLD_FROM_CAMERA,
    trace,
)

SOFA = UprightBox([3.0, 0, 0.4], [0.9, 1.8, 0.8], 0.1)


def extracted(
    depth: NDArray[np.float32],
    masks: NDArray[np.uint16],
    *labels: str,
    held: Held | None = None,
    box: Box | None = None,
) -> ExtractedScene:
    objects = [Annotation(mask=OBJECT + k, label=label, mounting=held, box=box) for k, label in enumerate(labels)]
    told = Annotations(objects=objects, floor=FLOOR, walls=[WALL])
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    image = AnnotatedImage(rgb, depth, masks, INTRINSICS, told)
    return reconstruct("room", image, ExtractionConfig(), np.random.default_rng(0))


def ends(item: SceneObject) -> tuple[float, float]:
    assert item.box is not None
    return item.box.center[2] - item.box.size[2] / 2, item.box.center[2] + item.box.size[2] / 2


@pytest.mark.parametrize("depth_of_box", [0.3, 0.5])  # its front stands back, or is flush
def test_what_stands_on_something_that_nobody_named_stays_there(depth_of_box: float) -> None:
    cabinet = UprightBox([3.0, 0, 0.3], [0.5, 1.0, 0.6], 0.0)
    depth, masks = trace([UprightBox([3.0, 0, 0.8], [depth_of_box, 0.6, 0.4], 0.0), cabinet])
    masks[masks == OBJECT + 1] = 0
    (item,) = extracted(depth, masks, "box").objects.objects
    assert ends(item)[0] == pytest.approx(0.6, abs=0.03) and item.measured_support == "unnamed"


@pytest.mark.parametrize(("height", "support"), [(0.9, "floor"), (0.2, "unnamed")])
def test_who_says_that_it_stands_is_right_unless_it_would_be_far_taller_than_seen(height: float, support: str) -> None:
    """On something of 40 cm without a mask: a cabinet whose foot was not drawn, say, or a box on a shelf."""
    low = UprightBox([3.0, 0, 0.2], [0.6, 1.0, 0.4], 0.0)
    depth, masks = trace([UprightBox([3.0, 0, 0.4 + height / 2], [0.4, 0.6, height], 0.0), low])
    masks[masks == OBJECT + 1] = 0
    (seen,) = extracted(depth, masks, "cabinet").objects.objects
    (said,) = extracted(depth, masks, "cabinet", held=Held(type=2)).objects.objects
    assert (seen.measured_support, said.measured_support) == ("unnamed", support)
    assert ends(said)[0] == pytest.approx(0 if support == "floor" else 0.4, abs=0.03)


def test_what_carries_it_is_said() -> None:
    table, box = UprightBox([2.6, 0, 0.3], [0.8, 1.2, 0.6], 0.0), UprightBox([2.6, 0, 0.75], [0.3, 0.4, 0.3], 0.0)
    found = extracted(*trace([table, box]), "table", "box").objects.objects
    assert [item.measured_support for item in found] == ["floor", "table_1"]


@pytest.mark.parametrize("label", ["desk", "thing"])
def test_clutter_that_nobody_named_moves_nothing(label: str) -> None:
    """A cup and a book on a desk, beside a box and a lamp that the desk's mask shows."""
    desk = UprightBox([2.4, 0, 0.375], [0.7, 1.4, 0.75], 0.1)
    cup, book = (
        UprightBox([2.25, -0.3, 0.8], [0.09, 0.09, 0.1], 0.0),
        UprightBox([2.25, 0.05, 0.765], [0.2, 0.15, 0.03], 0.2),
    )
    clutter = [UprightBox([2.5, 0.4, 0.85], [0.25, 0.3, 0.2], 0.1), UprightBox([2.5, -0.1, 0.95], [0.1, 0.1, 0.4], 0.1)]
    depth, masks = trace([desk, cup, book, *clutter])
    masks[masks > OBJECT + 2] = OBJECT
    found = extracted(depth, masks, label, "cup", "book")
    carrier, *things = found.objects.objects
    for item, height in zip(things, (0.1, 0.03), strict=True):
        assert item.measured_support == carrier.id and item.box is not None
        assert item.box.size[2] == pytest.approx(height, abs=0.015)
    if label == "desk":
        assert ends(carrier)[1] == pytest.approx(0.75, abs=0.015)


def test_depth_along_the_edge_of_a_wall_s_mask_moves_no_wall() -> None:
    depth, masks = trace([SOFA])
    edge = (masks == WALL) & ~erode(masks == WALL)
    mixed = np.where(edge, 0.996 * depth, depth).astype(np.float32)  # 2 cm nearer
    assert (
        extracted(mixed, masks, "sofa").objects.walls[0].offset
        == extracted(depth, masks, "sofa").objects.walls[0].offset
    )


@pytest.mark.parametrize(("value", "walls"), [(0, 1), (FLOOR, 0), (OBJECT, 0)])
def test_an_upright_plane_is_a_wall_unless_a_mask_says_what_it_is(value: int, walls: int) -> None:
    depth, masks = trace([SOFA])
    masks[masks == WALL] = value
    assert len(extracted(depth, masks, "sofa").objects.walls) == walls


SQUARE: list[tuple[float, float]] = [(4, 4), (36, 4), (36, 36), (4, 36)]


def test_what_stands_before_the_floor_takes_nothing_from_it() -> None:
    found, cut = np.full((40, 40), FLOOR, np.uint16), Cutter(np.zeros((40, 40, 3), np.uint8))
    box = Correction(mask=OBJECT, label="box", outline=SQUARE)
    for label, swallowed in (("floor", set()), ("rug", {FLOOR})):
        things = {FLOOR: Correction(mask=FLOOR, label=label), OBJECT: box}
        assert set(paint_masks(things, found, cut).swallowed) == swallowed


def test_what_was_drawn_covers_what_was_found_whichever_comes_first() -> None:
    found, cut = np.full((40, 40), OBJECT + 1, np.uint16), Cutter(np.zeros((40, 40, 3), np.uint8))
    drawn, whole = Correction(mask=OBJECT, label="cup", outline=SQUARE), Correction(mask=OBJECT + 1, label="table")
    for things in ([drawn, whole], [whole, drawn]):
        painted = paint_masks({item.mask: item for item in things}, found, cut).masks
        assert (painted[20, 20], painted[0, 0]) == (OBJECT, OBJECT + 1)
    for before, behind in ((1, 0), (0, -1)):  # unless a person says which is in front
        things = [whole.model_copy(update={"layer": before}), drawn.model_copy(update={"layer": behind})]
        assert (paint_masks({item.mask: item for item in things}, found, cut).masks == OBJECT + 1).all()


def test_what_was_drawn_anew_has_no_box_or_front_of_what_was_found() -> None:
    found, cut = np.full((40, 40), OBJECT, np.uint16), Cutter(np.zeros((40, 40, 3), np.uint8))
    stated = Box(center=(0, 0, 1), size=(1, 1, 1), yaw=0), True, 0.5
    known = dict(zip(("box", "guessed", "front"), stated, strict=True))
    given = Annotations(objects=[Annotation(mask=OBJECT, label="box", **known)], floor=None, walls=[])
    kept = []
    for told in ({}, {"outline": SQUARE}):
        corrected, _, _ = correct_masks(given, found, {OBJECT: Correction(mask=OBJECT, **told)}, cut)
        assert corrected is not None
        kept.append(tuple(getattr(corrected.objects[0], name) for name in known))
    assert kept == [stated, (None, False, None)]


def test_corrections_that_leave_nothing_are_refused() -> None:
    depth, masks = trace([SOFA])
    told = Annotations(objects=[Annotation(mask=OBJECT, label="sofa")], floor=FLOOR, walls=[WALL])
    image = AnnotatedImage(np.zeros((HEIGHT, WIDTH, 3), np.uint8), depth, masks, INTRINSICS, told)
    with refused("E-SCENE-EMPTY"):
        correct_image(image, {OBJECT: Correction(mask=OBJECT, gone=True)})


def test_a_wall_that_nobody_painted_carries_no_picture() -> None:
    picture = UprightBox([3.98, 0, 1.5], [0.04, 0.6, 0.5], 0.0)
    depth, masks = trace([picture])
    masks[masks == WALL] = 0
    view = DepthView(depth, INTRINSICS, WORLD_FROM_CAMERA, USUAL_ERROR)
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-BACK_WALL, points=100)
    shown = [measure_shelf(picture, walls, view, masks == OBJECT, masks == 0) for walls in ([], [wall])]
    assert shown == [pytest.approx(1.22, abs=0.02), None]
    (hung,) = extracted(depth, masks, "picture").objects.objects
    assert hung.mounting is not None and hung.mounting.type == 1 and hung.measured_support == "wall"


def test_what_lies_outside_the_central_crop_moves_neither_floor_nor_walls_nor_things() -> None:
    depth, masks = trace([SOFA])
    inside = central_crop(depth.shape, ExtractionConfig().crop)
    wrong = np.where(inside, depth, 0.7 * depth).astype(np.float32)
    assert extracted(wrong, masks, "sofa").objects == extracted(depth, masks, "sofa").objects


@pytest.mark.parametrize(("error", "removed"), [(DepthError(0.0, 0.0), True), (DepthError(0.1, 0.0), False)])
def test_noise_of_depth_behind_a_wall_is_no_reflection(error: DepthError, removed: bool) -> None:
    depth, masks = trace([UprightBox([BACK_WALL - 0.02, 0, 1.5], [0.04, 0.8, 0.9], 0.0)])
    right = (masks == OBJECT) & (np.arange(WIDTH) > WIDTH / 2)
    depth[right] *= 1 + 0.5 / BACK_WALL  # 46 cm behind the wall
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-BACK_WALL, points=100)
    seen = PointMap(depth, INTRINSICS, WORLD_FROM_CAMERA)
    clean = remove_reflections(depth, seen, [(masks == OBJECT, [])], [wall], error)
    assert np.array_equal((clean == 0) & (depth > 0), right & removed)


def test_a_mirror_is_not_as_deep_as_what_it_shows() -> None:
    mirror = UprightBox([BACK_WALL - 0.02, 0, 1.5], [0.04, 0.8, 0.9], 0.0)
    depth, masks = trace([mirror])
    shown = (masks == OBJECT) & (np.arange(WIDTH) > WIDTH / 2)
    result = extracted(np.where(shown, np.float32(9.0), depth), masks, "mirror")
    (item,) = result.objects.objects
    assert item.box is not None and item.mounting is not None and item.mounting.type == 1
    assert max(item.box.size) < 1.0 and item.box.center[0] < BACK_WALL + 0.1
    assert not result.depth[shown].any() and result.depth[(masks == OBJECT) & ~shown].all()
    behind = extracted(np.where(masks == OBJECT, np.float32(6.0), depth), masks, "chair")
    assert behind.depth[masks == OBJECT].all(), "all of it: seen through a door"


HUNG, STANDS = Held(type=1, walls=[WALL]), Held(type=2)


@pytest.mark.parametrize(
    ("label", "held", "on_wall"),
    [("wall mirror", None, True), ("chair", None, False), ("thing", None, False), ("thing", HUNG, True),
     ("wall mirror", STANDS, False)],
)  # fmt: skip
def test_a_mirror_that_is_seen_wholly_behind_its_wall_hangs_on_it(label: str, held: Held | None, on_wall: bool) -> None:
    depth, masks = trace([UprightBox([BACK_WALL - 0.02, 0, 1.5], [0.04, 0.8, 0.9], 0.0)])
    shown = np.where(masks == OBJECT, np.float32(6.5), depth)  # what it shows is as far away as that
    (item,) = extracted(shown, masks, label, held=held).objects.objects
    assert item.box is not None and item.mounting is not None
    assert (abs(item.box.center[0] - BACK_WALL) < 0.1) == on_wall == item.mounting.hangs
    assert not on_wall or list(item.box.size[1:]) == pytest.approx([0.8, 0.9], abs=0.08)


def test_what_is_said_to_stand_before_a_wall_hangs_on_none() -> None:
    walls = {WALL: Wall(id="wall_1", normal=(-1, 0, 0), offset=-BACK_WALL, points=100)}
    mirror = Annotation(mask=OBJECT, label="wall mirror")
    assert find_hanging(mirror, [*walls.values()], walls) == [*walls.values()]
    before = mirror.model_copy(update={"mounting": Held(type=3, walls=[WALL])})
    assert find_hanging(before, [*walls.values()], walls) == []


@pytest.mark.parametrize(("held", "front", "left"), [(None, 6.5, False), (HUNG, 6.5, True), (HUNG, 4.1, False)])
def test_a_box_far_behind_the_wall_where_its_thing_hangs_is_left(held: Held | None, front: float, left: bool) -> None:
    """As it was drawn into a photograph, before somebody said that it hangs there."""
    depth, masks = trace([UprightBox([BACK_WALL - 0.02, 0, 1.5], [0.04, 0.8, 0.9], 0.0)])
    shown = np.where(masks == OBJECT, np.float32(front), depth)
    box = Box(center=(round(front + 0.1, 3), 0, 1.4), size=(0.1, 1.3, 1.5), yaw=0.0)
    (item,) = extracted(shown, masks, "thing", held=held, box=box).objects.objects
    assert item.box is not None and item.mounting is not None
    assert item.mounting.hangs == (held is not None) and (item.box == box) == (not left)
    assert not left or item.box.center[0] == pytest.approx(BACK_WALL, abs=0.1)


@pytest.mark.parametrize(("share", "removed"), [(0.3, True), (0.9, False)])  # of a cupboard in a niche little is before
def test_what_a_sensor_smears_between_a_mirror_and_what_it_shows_is_no_part_of_it(share: float, removed: bool) -> None:
    depth, masks = trace([UprightBox([BACK_WALL - 0.02, 0, 1.5], [0.04, 0.8, 0.9], 0.0)])
    columns = np.flatnonzero((masks == OBJECT).any(axis=0))
    smeared = (masks == OBJECT) & (np.arange(WIDTH) > np.quantile(columns, 1 - share))
    depth[smeared] *= 1 + 0.2 / BACK_WALL  # 18 cm behind the wall
    wall = Wall(id="wall_1", normal=(-1, 0, 0), offset=-BACK_WALL, points=100)
    seen = PointMap(depth, INTRINSICS, WORLD_FROM_CAMERA)
    clean = remove_reflections(depth, seen, [(masks == OBJECT, [])], [wall], DepthError(0.01, 0.0))
    assert np.array_equal((clean == 0) & (depth > 0), smeared & removed)
