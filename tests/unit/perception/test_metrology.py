"""Single-view metrology with known answers: what is projected from a room and measured in the picture is that room."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from roomkin.stages.geometry.boxes import UprightBox, corners, oriented_iou
from roomkin.stages.geometry.frames import rotation_of
from roomkin.stages.perception.camera.metrology import (
    MetrologyError,
    PinholeView,
    depth_by_pixel,
    fit_hanging_box,
    fit_standing_box,
    round_box,
    wall_plane,
)
from roomkin.stages.perception.camera.perspective import (
    Guide,
    Perspective,
    angles_of,
    fit_view,
    horizon,
    propose,
    usual_focal,
    vanishing_point,
)
from roomkin.stages.perception.drawing.outlined import support_at
from roomkin.stages.perception.drawing.project import DrawnObject, DrawnWall, Project, Scale, camera_factor
from roomkin.stages.perception.drawing.solve import solve

ROOM = Path(__file__).parents[3] / "tests/data/photographed_room"  # room_1 of the default run, as JPEG, and its truth
YAW, PITCH, ROLL = np.deg2rad([12.0, -15.0, 1.5])
VIEW = PinholeView(800, 600, 640.0, rotation_of(YAW, PITCH, ROLL), 1.6)
NOTHING = (None, None, None)
BOX = UprightBox([0.4, 3.2, 0.45], [0.8, 0.5, 0.9], 0.0)
WALL = -4.0  # normal (0, -1, 0): the wall is y = 4


def _seen(box: UprightBox, *which: int) -> list[tuple[float, float]]:
    return [tuple(pixel) for pixel in VIEW.project(corners(box)[list(which)]).tolist()]


def _perspective(view: PinholeView = VIEW, **changes: object) -> Perspective:
    """Lines of three axes through the room, exactly as `view` shows them."""
    starts = np.array([[-1.0, 3, 0], [1, 2.5, 0.3], [0.5, 4, 1.2]])
    guides = []
    for axis, step in zip("xyz", np.eye(3), strict=True):
        for start in starts:
            a, b = view.project([start, start + 0.9 * step]).tolist()
            guides.append(Guide(axis=axis, a=tuple(a), b=tuple(b)))  # type: ignore[arg-type]
    return Perspective(guides=guides, likely_focal=500).model_copy(update=changes)


def _project(**parts: object) -> Project:
    given = {"perspective": _perspective(), "scale": Scale(metres=1.6), **parts}
    return Project(picture="room.jpg", width=800, height=600, **given)  # type: ignore[arg-type]


def _same(view: PinholeView, true: PinholeView = VIEW, degrees: float = 0.1) -> None:
    turn = view.rotation.T @ true.rotation
    assert np.rad2deg(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))) < degrees


def test_what_is_projected_is_found_again() -> None:
    assert np.linalg.det(VIEW.rotation) == pytest.approx(1) and angles_of(VIEW.rotation) == pytest.approx(
        (YAW, PITCH, ROLL)
    )
    assert VIEW.rotation[2, 2] == pytest.approx(np.sin(PITCH))  # the optical axis points down
    right = VIEW.rotation[:, 0]
    assert right[2] < 0  # rolled clockwise: the camera's right side is the lower one
    point = np.array([0.7, 3.0, 0.4])
    np.testing.assert_allclose(VIEW.meet_level(VIEW.project(point), 0.4), point, atol=1e-9)
    np.testing.assert_allclose(VIEW.meet_plane(VIEW.project(point), [0, -1, 0], -3.0), point, atol=1e-9)
    behind = VIEW.project([0, -3.0, 0])
    assert np.isnan(behind).all()
    with pytest.raises(MetrologyError, match="above the horizon"):
        VIEW.meet_level((400, 20))


def test_lines_of_three_directions_give_the_camera() -> None:
    view = fit_view(_perspective(), 800, 600)
    assert view.focal == pytest.approx(640, rel=2e-3)
    _same(view)
    (u0, v0), (u1, v1) = horizon(view)
    far = VIEW.project([[-4000.0, 9000, 1.6], [3000, 9000, 1.6]])
    for u, v in far:
        assert v0 + (v1 - v0) * (u - u0) / (u1 - u0) == pytest.approx(v, abs=1)
    seen = vanishing_point(view, 1)
    assert seen is not None
    np.testing.assert_allclose(seen, VIEW.project([0, 1e7, 0]), atol=0.7)


def test_a_wrong_line_does_not_bend_the_room() -> None:
    given = _perspective()
    a, b = VIEW.project([[0.2, 3.0, 0.7], [1.1, 3.2, 0.7]]).tolist()  # along a table that is turned by 12 degrees
    given.guides.append(Guide(axis="x", a=tuple(a), b=tuple(b)))
    view = fit_view(given, 800, 600)
    _same(view, degrees=0.3)
    assert view.focal == pytest.approx(640, rel=0.01)


def test_what_lines_leave_open_is_as_is_usual_and_what_is_fixed_stays() -> None:
    frontal = PinholeView(
        800, 600, 640, rotation_of(0, 0, 0), 1.6
    )  # one-point perspective says nothing of the focal length
    assert fit_view(_perspective(frontal, likely_focal=700.0), 800, 600).focal == pytest.approx(700, rel=0.02)
    assert fit_view(_perspective(frontal, focal=555.0), 800, 600).focal == pytest.approx(555, rel=0.01)
    bare = fit_view(Perspective(likely_focal=640), 800, 600)
    assert abs(bare.rotation[2, 0]) < 1e-3 and bare.focal == pytest.approx(640, rel=1e-3)
    pinned = Perspective(likely_focal=640, spread=0.02, horizon=((0, 140), (799, 120)))
    (_, v0), (_, v1) = horizon(fit_view(pinned, 800, 600))
    assert (v0, v1) == (pytest.approx(140, abs=1.5), pytest.approx(120, abs=1.5))
    away = vanishing_point(fit_view(Perspective(likely_focal=640, spread=0.02, y=(610, 180)), 800, 600), 1)
    assert away == (pytest.approx(610, abs=2), pytest.approx(180, abs=2))


@pytest.mark.parametrize("turn", [0.0, 0.4], ids=["along the walls", "turned"])
def test_a_standing_box_from_four_pixels(turn: float) -> None:
    box = replace(BOX, yaw=turn)
    left, right, top, rear = _seen(box, 0, 1, 4, 6)
    found = fit_standing_box(VIEW, 0.0, [left, right, top, rear], NOTHING, free=bool(turn))
    assert oriented_iou(found, box) > 0.999
    other = fit_standing_box(VIEW, 0.0, [right, left, top, _seen(box, 7)[0]], NOTHING, free=bool(turn))
    assert oriented_iou(other, box) > 0.999  # drawn from right to left, another rear corner
    on_it = UprightBox([0.5, 3.1, 1.0], [0.2, 0.2, 0.2], turn)
    raised = fit_standing_box(VIEW, 0.9, _seen(on_it, 0, 1, 5, 7), NOTHING, free=bool(turn))
    assert oriented_iou(raised, on_it) > 0.999


def test_noise_does_not_turn_a_box_that_stands_along_the_walls() -> None:
    left, right, top, rear = _seen(BOX, 0, 1, 4, 6)
    found = fit_standing_box(VIEW, 0.0, [left, (right[0], right[1] + 3), top, rear], NOTHING, free=False)
    assert found.yaw == pytest.approx(0) and np.linalg.norm(np.subtract(found.center, BOX.center)) < 0.06


def test_a_round_thing_from_three_pixels() -> None:
    center, radius = np.array([0.6, 2.8, 0.0]), 0.25
    top = np.array([0, 0, 0.7])
    beside = np.array([center[1], -center[0], 0]) / np.hypot(*center[:2]) * radius  # as seen from the camera
    pixels = [tuple(pixel) for pixel in VIEW.project([center - beside, center + beside, center + top]).tolist()]
    found = round_box(VIEW, 0.0, pixels, NOTHING)  # type: ignore[arg-type]
    np.testing.assert_allclose(np.asarray(found.center), [0.6, 2.8, 0.35], atol=1e-6)
    np.testing.assert_allclose(np.asarray(found.size), [0.5, 0.5, 0.7], atol=1e-6)
    for side in (-2.4, 2.4):  # a table: its top is wider than its foot
        pixels[2] = tuple(VIEW.project(center + side * beside + top).tolist())
        table = round_box(VIEW, 0.0, pixels, NOTHING)  # type: ignore[arg-type]
        np.testing.assert_allclose(np.asarray(table.center), [0.6, 2.8, 0.35], atol=1e-6)
        np.testing.assert_allclose(np.asarray(table.size), [1.2, 1.2, 0.7], atol=1e-6)
    typed = round_box(VIEW, 0.0, pixels, (1.0, None, 0.8))  # type: ignore[arg-type]
    np.testing.assert_allclose(np.asarray(typed.size), [1.0, 1.0, 0.8])
    with pytest.raises(MetrologyError, match="top lies below"):
        round_box(VIEW, 0.0, [*pixels[:2], (pixels[0][0], pixels[0][1] + 30)], NOTHING)  # type: ignore[list-item]


def test_typed_sizes_count_for_more_than_the_picture() -> None:
    left, right, top, rear = _seen(BOX, 0, 1, 4, 6)
    found = fit_standing_box(VIEW, 0.0, [left, right, top, rear], (1.0, 0.6, 2.0), free=False)
    assert np.asarray(found.size).tolist() == [1.0, 0.6, 2.0] and found.bottom == pytest.approx(0)
    np.testing.assert_allclose(np.asarray(found.center)[:2], [0.4, 2.95 + 0.3], atol=1e-6)  # its front stays
    guessed = fit_standing_box(VIEW, 0.0, [left, right, top], NOTHING, free=False)
    assert np.asarray(guessed.size)[1] == pytest.approx(0.6)


def test_a_hanging_box_from_three_pixels() -> None:
    box = UprightBox([-0.6, 3.82, 1.6], [0.9, 0.36, 0.7], 0.0)
    wall = wall_plane(VIEW, *VIEW.project([[-1, 4, 0], [1, 4, 0]]), free=False)
    np.testing.assert_allclose([*wall.normal, wall.offset], [0, -1, 0, WALL], atol=1e-6)
    for rear in (3, 2, 7):
        found = fit_hanging_box(VIEW, wall, [*_seen(box, 0, 5), *_seen(box, rear)], NOTHING)
        assert oriented_iou(found, box) > 0.97
    flat = fit_hanging_box(
        VIEW, wall, _seen(replace(box, center=[-0.6, 3.985, 1.6], size=[0.9, 0.03, 0.7]), 0, 5), NOTHING
    )
    assert np.asarray(flat.size)[1] == pytest.approx(0.03)


def test_no_wall_goes_through_the_camera() -> None:
    for aside in (-0.1, 0.1):
        ends = VIEW.project([[aside, 3, 0], [aside, 4, 0]])
        assert wall_plane(VIEW, *ends, free=True).offset == pytest.approx(-0.1)
    with pytest.raises(MetrologyError, match="through the camera"):
        wall_plane(VIEW, *VIEW.project([[0, 3, 0], [0, 4, 0]]), free=True)


def test_drawings_without_a_meaning_say_why() -> None:
    left, right, top, _ = _seen(BOX, 0, 1, 4, 6)
    with pytest.raises(MetrologyError, match="top lies below"):
        fit_standing_box(VIEW, 0.0, [left, right, (left[0], left[1] + 40)], NOTHING, free=False)
    with pytest.raises(MetrologyError, match="same point"):
        fit_standing_box(VIEW, 0.0, [left, left, top], NOTHING, free=False)
    with pytest.raises(MetrologyError, match="before its front"):
        depth_by_pixel(VIEW, corners(BOX)[[0, 1]], np.array([0, 1.0, 0]), VIEW.project([0.4, 1.8, 0]))


def _drawn(name: str, box: UprightBox, on: str = "floor", **more: object) -> DrawnObject:
    return DrawnObject(id=name, on=on, points=_seen(box, 0, 1, 4, 6), **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "scale",
    [
        Scale(metres=1.6),
        Scale(kind="object", object="cabinet", side="width", metres=0.8),
        Scale(kind="upright", points=tuple(_seen(BOX, 1, 5)), metres=0.9),  # type: ignore[arg-type]
        Scale(kind="floor", points=tuple(_seen(BOX, 0, 1)), metres=0.8),  # type: ignore[arg-type]
    ],
    ids=lambda scale: scale.kind,
)
def test_any_known_length_gives_the_scale(scale: Scale) -> None:
    mug = UprightBox([0.5, 3.1, 0.95], [0.1, 0.1, 0.1], 0.0)
    hung = UprightBox([-0.6, 3.82, 1.6], [0.9, 0.36, 0.7], 0.0)
    picture = DrawnObject(id="hung", on="back", points=_seen(hung, 0, 5, 3))
    a, b = VIEW.project([[-1, 4, 0], [1, 4, 0]]).tolist()
    drawing = _project(
        scale=scale,
        walls=[DrawnWall(id="back", a=tuple(a), b=tuple(b))],
        objects=[_drawn("mug", mug, "cabinet"), _drawn("cabinet", BOX), picture],  # what carries may come later
    )
    solved = solve(drawing)
    assert solved.notes == {} and solved.view.above == pytest.approx(1.6, rel=5e-3)
    for name, true in {"mug": mug, "cabinet": BOX, "hung": hung}.items():
        assert np.linalg.norm(np.subtract(solved.boxes[name].center, true.center)) < 0.03, name
    assert support_at(solved, _seen(mug, 0)[0]) == "cabinet"
    u, v = VIEW.project([0.6, 2.95, 0.9])  # the front edge of the top, missed by four pixels, then by more
    assert support_at(solved, (u, v + 4)) == "cabinet" != support_at(solved, (u, v + 20))
    assert support_at(solved, (400, 590)) == "floor"
    assert support_at(solved, _seen(hung, 5)[0]) == "back"


def test_what_has_no_place_does_not_stop_the_rest() -> None:
    sky = DrawnObject(id="sky", points=[(100, 10), (200, 10), (100, 5)])
    ring = [_drawn("one", BOX, "two"), _drawn("two", BOX, "one")]
    solved = solve(_project(objects=[_drawn("cabinet", BOX), sky, *ring, _drawn("lost", BOX, "nowhere")]))
    assert list(solved.boxes) == ["cabinet"]
    assert "horizon" in solved.notes["sky"] and "not there" in solved.notes["lost"]
    assert any("itself" in solved.notes[name] for name in ("one", "two"))
    unmeasured = solve(_project(scale=Scale(kind="upright", metres=2), objects=[_drawn("cabinet", BOX)]))
    assert "draw the line" in unmeasured.notes["scale"] and unmeasured.view.above == 1.5
    low = DrawnObject(id="low", points=_seen(BOX, 0, 1, 4))
    bent = _drawn("bent", BOX)
    bent.points[3] = _seen(BOX, 0)[0][0], 590.0
    hung = UprightBox([-0.6, 3.82, 1.6], [0.9, 0.36, 0.7], 0.0)
    off = DrawnObject(id="off", on="back", points=[*_seen(hung, 0, 5), (400, 300)])
    a, b = VIEW.project([[-1, 4, 0], [1, 4, 0]]).tolist()
    wall = DrawnWall(id="back", a=tuple(a), b=tuple(b))
    assert solve(_project(objects=[off], walls=[wall])).boxes["off"].size[2] > 0.3  # type: ignore[index]
    beside = _drawn("beside", replace(BOX, center=[-1.5, 3.2, 1.1], size=[0.2, 0.2, 0.2]), "low")
    guessed = solve(_project(objects=[low, bent, beside]))
    assert "depth is guessed" in guessed.notes["low"] and "beside" in guessed.notes["beside"]
    assert "before its front" in guessed.notes["bent"] and np.asarray(guessed.boxes["bent"].size)[1] == 0.6


def test_a_thing_whose_top_was_not_marked_says_nothing_of_the_camera_s_height() -> None:
    low = UprightBox(BOX.center, [0.7, 0.7, 0.45], 0.0)
    factors = []
    for count in (2, 3):
        fridge = DrawnObject(id="fridge", label="fridge", points=_seen(BOX, 0, 1, 4)[:count])
        factors.append(camera_factor(_project(scale=Scale(), objects=[fridge]), {"fridge": low}))
    assert factors[0] is None and factors[1] is not None and factors[1] > 2


def test_the_camera_is_proposed_from_a_picture_alone() -> None:
    rgb = np.asarray(cv2.imread(str(ROOM / "rgb.jpg"))[..., ::-1], dtype=np.uint8)
    height, width = rgb.shape[:2]
    true = json.loads((ROOM / "camera.json").read_text())["intrinsics"][0][0]
    up = np.array(json.loads((ROOM / "truth.json").read_text())["world_from_camera"])[2, :3]
    proposed = propose(rgb, usual_focal(width, height, None))
    view = fit_view(proposed, width, height)
    assert view.focal == pytest.approx(true, rel=0.03)
    assert np.rad2deg(np.arccos(view.rotation[2] @ up)) < 0.5
    assert {guide.axis for guide in proposed.guides} == {"x", "y", "z"}
    assert propose(rgb, usual_focal(width, height, None)) == proposed
    known = propose(rgb, Perspective(likely_focal=true, spread=0.03))
    assert fit_view(known, width, height).focal == pytest.approx(true, rel=0.01)
    nothing = propose(np.full((300, 400, 3), 90, np.uint8), usual_focal(400, 300, None))
    assert nothing.guides == [] and fit_view(nothing, 400, 300).focal == pytest.approx(320, rel=0.01)


def test_a_camera_that_sees_no_floor_is_not_proposed() -> None:
    """Lines of a ceiling 40 degrees up: who draws stands over a floor or a table, and sees it."""
    up = PinholeView(640, 480, 520.0, rotation_of(0.2, np.deg2rad(40), 0.0))
    drawn = np.full((480, 640, 3), 90, np.uint8)
    for k in np.linspace(-6, 6, 13):
        for ends in ([[k, 1.0, 3.0], [k, 9.0, 3.0]], [[-6.0, 5 + k / 2, 3.0], [6.0, 5 + k / 2, 3.0]]):
            a, b = np.rint(up.project(ends)).astype(int).tolist()
            cv2.line(drawn, a, b, (220, 220, 220), 2, cv2.LINE_AA)
    view = fit_view(propose(drawn, usual_focal(640, 480, None)), 640, 480)
    bottom = view.rays([[0.0, 479.0], [639.0, 479.0]])
    assert (bottom[:, 2] < 0).all()
