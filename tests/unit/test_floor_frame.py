"""The floor frame of a picture against the floor that is seen; heights at which nobody holds a camera; noise."""

import numpy as np
import pytest

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts import Annotations
from roomkin.stages.contracts.objects import Box, SceneObject
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.extraction.floor import (
    check_frame,
    doubt_height,
    doubt_unit,
    find_floor_frame,
    find_unnamed_floor,
    fit_shown_floor,
)
from roomkin.stages.extraction.noise import AnnotatedImage
from roomkin.stages.extraction.reconstruct import ExtractedScene, reconstruct
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import PointMap, make_transform
from roomkin.stages.geometry.room_planes import Plane, WallPlane, make_floor_frame
from tests.refusals import refused
from tests.unit.synthetic_room import FLOOR, HEIGHT, INTRINSICS, OBJECT, WALL, WIDTH, WORLD_FROM_CAMERA, trace

BOX = UprightBox([2.5, 0.0, 0.3], [0.5, 0.6, 0.6], 0.0)
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def extracted(frame: np.ndarray | None, depth: np.ndarray | None = None, floor: bool = True) -> ExtractedScene:
    seen, masks = trace([BOX])
    told = Annotations(
        objects=[Annotation(mask=OBJECT, label="box")], floor=FLOOR if floor else None, walls=[WALL] if floor else []
    )
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    image = AnnotatedImage(rgb, seen if depth is None else depth, masks, INTRINSICS, told, floor_from_camera=frame)
    return reconstruct("room", image, ExtractionConfig(), np.random.default_rng(0))


def turned(rotation: np.ndarray, height: float = 1.6) -> np.ndarray:
    return make_transform(rotation @ WORLD_FROM_CAMERA[:3, :3], [0, 0, height])


def about_y(degrees: float) -> np.ndarray:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def test_a_frame_that_is_right_is_taken(capsys: pytest.CaptureFixture[str]) -> None:
    found = extracted(turned(about_y(1.0), 1.63)).objects
    assert found.floor_from_camera[2][3] == 1.63 and capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("frame", "word"),
    [
        (turned(UPSIDE_DOWN), "upside down"),
        (turned(about_y(40.0)), "turned by 40 degrees"),  # it looks up
        (turned(np.eye(3), 1.0), "1.00 m above the floor, depth of the floor's pixels 1.60 m"),
    ],
)
def test_a_frame_that_is_not_that_of_the_floor_is_refused(frame: np.ndarray, word: str) -> None:
    with refused("E-FLOOR-FRAME", word):
        extracted(frame)


def test_without_a_mask_of_the_floor_level_planes_tell_what_is_up() -> None:
    assert extracted(turned(about_y(5.0)), floor=False).objects.walls is not None
    for rotation, word in ((UPSIDE_DOWN, "upside down"), (about_y(60.0), "turned by 60 degrees")):
        with refused("E-FLOOR-FRAME", word):
            extracted(turned(rotation), floor=False)


@pytest.mark.parametrize("floor", [True, False])
def test_noise_is_no_depth(floor: bool) -> None:
    rng = np.random.default_rng(0)
    with refused("E-DEPTH-NOISE", "noise"):
        extracted(None, rng.uniform(0.5, 8.0, (HEIGHT, WIDTH)).astype(np.float32), floor)


def test_a_floor_above_the_camera_is_none() -> None:
    """A ceiling that was painted as the floor: every level plane is above the camera."""
    v = np.arange(HEIGHT)[:, None] - (HEIGHT - 1) / 2
    ceiling = np.where(v < -1, INTRINSICS[0, 0] / -np.minimum(v, -1), 0.0) * np.ones((1, WIDTH))
    depth = np.where(ceiling < 15, ceiling, 0).astype(np.float32)
    with refused("E-PICTURE-UPSIDE-DOWN", "a ceiling without a floor"):
        extracted(None, depth)
    masks = np.full(depth.shape, FLOOR, np.uint16)
    told = Annotations(objects=[Annotation(mask=OBJECT, label="box")], floor=FLOOR, walls=[])
    image = AnnotatedImage(np.zeros((*depth.shape, 3), np.uint8), depth, masks, INTRINSICS, told)
    assert fit_shown_floor(image, PointMap(depth, INTRINSICS), 30.0, np.random.default_rng(0)) is None


def test_a_room_that_cannot_be_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    behind = WallPlane(np.array([-1.0, 0, 0]), 1.0, 100)  # the camera is behind this wall
    monkeypatch.setattr("roomkin.stages.geometry.room_planes.fit_wall", lambda *_: behind)
    with refused("E-ROOM-BROKEN", "the camera is behind 'wall_1'"):
        extracted(None)


@pytest.mark.parametrize(
    ("height", "words"),
    [
        (1.6, []), (0.4, []), (5.74, ["5.74 m", "feet (1.75 m)"]), (3.57, ["half the picture's size (1.78 m)"]),
        (0.09, ["0.90 m", "8 bits"]), (40.0, ["40.00 m"]),
    ],
)  # fmt: skip
def test_a_height_at_which_nobody_holds_a_camera_is_doubted(height: float, words: list[str]) -> None:
    doubt = doubt_height(height)
    assert bool(doubt) == bool(words) and all(word in doubt for word in words)


def test_feet_are_doubted(capsys: pytest.CaptureFixture[str]) -> None:
    depth = trace([BOX])[0] / 0.3048
    extracted(None, depth.astype(np.float32))
    assert "depth in feet (1.60 m)" in capsys.readouterr().out


def test_a_camera_that_looks_straight_down_has_its_upper_edge_ahead() -> None:
    frame = make_floor_frame(Plane(np.array([0.0, 0.0, -1.0]), -2.0, np.ones(3, bool)))
    assert frame[:3, 1] == pytest.approx([-1, 0, 0]), "down in the picture is back in the room"
    assert frame[:3, 3] == pytest.approx([0, 0, 2]) and np.linalg.det(frame[:3, :3]) == pytest.approx(1)


def test_a_given_frame_may_lean_where_no_mask_shows_the_floor() -> None:
    up, shown = np.array([0.0, -1.0, 0.0]), Plane(np.array([0.0, -1.0, 0.0]), -1.5, np.ones(3, bool))
    leaning, lying = (
        make_floor_frame(Plane(np.array([0.0, -np.cos(angle), np.sin(angle)]), -1.5, shown.inliers))
        for angle in np.deg2rad([30, 60])
    )
    check_frame(leaning, None, up)
    for frame, floor in ((leaning, shown), (lying, None)):
        with refused("E-FLOOR-FRAME"):
            check_frame(frame, floor, up)


def test_a_given_frame_changes_no_number_that_is_drawn_later() -> None:
    depth, masks = trace([BOX])
    told = Annotations(objects=[Annotation(mask=OBJECT, label="box")], floor=FLOOR, walls=[WALL])
    rgb, frame = np.zeros((HEIGHT, WIDTH, 3), np.uint8), turned(np.eye(3), 1.6)
    image = AnnotatedImage(rgb, depth, masks, INTRINSICS, told, floor_from_camera=frame)
    rng = np.random.default_rng(0)
    find_floor_frame(image, PointMap(depth, INTRINSICS), 30.0, rng)
    assert rng.bit_generator.state == np.random.default_rng(0).bit_generator.state


@pytest.mark.parametrize(("value", "below"), [(0, 1.6), (WALL, 0.9)])
def test_what_a_mask_calls_a_wall_is_no_floor(value: int, below: float) -> None:
    """A table that nobody named, and something that hangs in the air."""
    depth, masks = trace([UprightBox([2.3, 0, 0.35], [1.6, 2.4, 0.7], 0.0), UprightBox([3, 0, 1.6], [0.2] * 3, 0.0)])
    shown = masks.copy()
    shown[masks == FLOOR], shown[masks == OBJECT] = value, 0
    told = Annotations(objects=[Annotation(mask=OBJECT + 1, label="lamp")], floor=None, walls=[WALL])
    image = AnnotatedImage(np.zeros((HEIGHT, WIDTH, 3), np.uint8), depth, shown, INTRINSICS, told)
    floor = find_unnamed_floor(image, PointMap(depth, INTRINSICS), WORLD_FROM_CAMERA[2, :3], 75.0)
    assert -floor.offset == pytest.approx(below, abs=0.03)


HEIGHTS = {"chair": 0.9, "dining table": 0.74, "fridge": 1.8}


def see_things(times: float, heights: dict[str, float] = HEIGHTS) -> list[SceneObject]:
    boxes = {
        label: Box(center=(2, 0, high / 2), size=(0.5, 0.5, high * times), yaw=0) for label, high in heights.items()
    }
    return [SceneObject.model_construct(id=label, label=label, status="ok", box=box) for label, box in boxes.items()]


@pytest.mark.parametrize(("unit", "says"), [(256, "--unit 256"), (4000, "--unit 4000"), (5000, "--unit 5000")])
def test_one_factor_of_all_things_is_told_with_the_unit_that_fits(unit: float, says: str) -> None:
    """Depth of which `unit` stands for a metre was read as millimetres."""
    assert f"{says} if depth was read as mm" in doubt_unit(see_things(unit / 1000))
    assert "things are" in doubt_unit([*see_things(unit / 1000), *see_things(1, {"gearbox": 0.01})])


def test_things_of_usual_size_or_wrong_by_several_factors_ask_for_no_unit() -> None:
    assert doubt_unit(see_things(1)) == "" and doubt_unit(see_things(1.3)) == ""
    assert doubt_unit(see_things(0.25, {"chair": 0.9})) == "", "one thing may be wrong for other reasons"
    assert doubt_unit(see_things(1, {"chair": 0.2, "dining table": 3.0, "fridge": 1.8})) == ""
    assert doubt_unit(see_things(1, {"chair": 0.22, "fridge": 0.45, "dining table": 3.0})) == "", "one fits no factor"
    assert doubt_unit(see_things(1, {"book": 0.041, "vase": 0.151})) == "", "low, and usual"
