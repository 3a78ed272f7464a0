"""Rooms without a simulator: counts and scales of Table 2, casting, layout, framing."""

import copy
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from roomkin.plugins.scenes.chance import EYE, are_all_seen, draw_room, frame, redraw_recipe
from roomkin.plugins.scenes.layout import CastRoom, arrange, cast, scale_of
from roomkin.plugins.scenes.recipe import (
    Against,
    Beside,
    Floor,
    Item,
    On,
    RoomPlan,
    ScenesConfig,
    read_room,
    room_files,
    series,
)
from roomkin.stages.contracts import InputError
from roomkin.stages.geometry.boxes import UprightBox, corners, footprint
from roomkin.stages.geometry.frames import invert_transform, look_at, project, transform_points
from tests.refusals import refused
from tests.unit.scene_models import default_models
from tests.unit.synthetic_room import hit_box

TABLE_2 = [(5, 3.68), (6, 3.42), (6, 2.91), (5, 3.54), (6, 3.24), (8, 4.17), (12, 6.89), (15, 10.23)]
MIN_PIXELS = 100  # per object at 800 x 600
ROOT = Path(__file__).resolve().parents[3]
ROOMS = [read_room(path) for path in series()]
NOWHERE = Path("library.json")


@pytest.fixture(scope="module", params=[0, 1])
def cast_rooms(request: pytest.FixtureRequest) -> dict[str, CastRoom]:
    return cast(ROOMS, default_models(request.param), request.param, NOWHERE)


def test_counts_and_scales_of_table_2(cast_rooms: dict[str, CastRoom]) -> None:
    assert list(cast_rooms) == [f"room_{k}" for k in range(1, 9)]
    for room, (count, scale) in zip(cast_rooms.values(), TABLE_2, strict=True):
        centers = np.array([standing.box.center for standing in room.layout.standing.values()])
        assert len(centers) == count
        assert scale_of(centers) == pytest.approx(scale, abs=0.01)


@pytest.mark.parametrize("room", [ROOMS[2], ROOMS[7]], ids=lambda room: room.name)
def test_a_room_drawn_by_chance_keeps_its_scale_and_hides_nothing(room: RoomPlan) -> None:
    drawn = [draw_room(room, default_models(0), seed, NOWHERE, ScenesConfig()) for seed in (1, 1, 2)]
    places = [[tuple(np.round(item.box.center, 6)) for item in one.layout.standing.values()] for one in drawn]
    assert places[0] == places[1] != places[2]
    for one in drawn:
        standing = list(one.layout.standing.values())
        assert scale_of(np.array([item.box.center for item in standing])) == pytest.approx(room.scale, abs=0.01)
        points = np.concatenate([corners(item.box) for item in standing])
        camera = frame(points, one.room.camera, 800, 600, 0.06)
        assert are_all_seen([item.box for item in standing], *camera, 800, 600)
        assert [asset.category for asset in one.assets.values()] == [item.category for item in room.items]


def test_a_room_that_is_not_moved_is_itself_or_its_mirror_image() -> None:
    sizes = {item.name: (0.4, 0.5, 0.6) for room in ROOMS for item in room.items}
    arranged = [(room, stands) for room in ROOMS if (stands := arrange(room, sizes)) is not None]
    assert any(isinstance(item.place, Beside) for room, _ in arranged for item in room.items)
    for room, stands in arranged:
        seen, heights = set(), set()
        for seed in range(8):
            drawn = redraw_recipe(room, np.random.default_rng(seed), 0.0)
            side = np.sign(drawn.camera.azimuth * room.camera.azimuth)
            placed = arrange(drawn, sizes)
            assert placed is not None
            for name, item in placed.standing.items():
                assert item.box.center == pytest.approx(stands.standing[name].box.center * [1, side, 1])
            seen.add(side)
            heights.add(drawn.camera.height)
        assert seen == {-1, 1} and len(heights) == 8
        assert max(abs(height - room.camera.height) for height in heights) <= EYE


def test_what_stands_behind_something_is_not_seen() -> None:
    camera = np.diag([400.0, 400.0, 1.0]), look_at([4.0, 0.0, 1.0], [0.0, 0.0, 1.0])
    camera[0][:2, 2] = 400, 300
    front, back = (UprightBox((x, 0, 1.0), (0.2, 1.0, 1.0), 0.0) for x in (1.0, -1.0))
    assert are_all_seen([back], *camera, 800, 600) and not are_all_seen([front, back], *camera, 800, 600)
    for beside, seen in ((-0.4, False), (-0.6, True)):  # a third of it shows, or two thirds
        before = UprightBox((1.0, beside, 1.0), (0.2, 1.0, 1.0), 0.0)
        assert are_all_seen([before, back], *camera, 800, 600) == seen


def test_no_model_stands_in_two_rooms(cast_rooms: dict[str, CastRoom]) -> None:
    used = [asset.id for room in cast_rooms.values() for asset in room.assets.values()]
    assert len(used) == len(set(used)) == sum(count for count, _ in TABLE_2)


def test_boxes_do_not_overlap_and_rest_on_their_support(cast_rooms: dict[str, CastRoom]) -> None:
    for room in cast_rooms.values():
        standing = room.layout.standing
        for name, one in standing.items():
            if one.support in standing:
                below = standing[one.support].box
                assert one.box.bottom == pytest.approx(below.top)
                assert footprint(below).buffer(0.003).covers(footprint(one.box))
            elif one.support == "floor":
                assert one.box.bottom == pytest.approx(0, abs=1e-9)
            for other_name, other in standing.items():
                above = one.box.bottom >= other.box.top - 0.003 or other.box.bottom >= one.box.top - 0.003
                if name < other_name and not above:
                    overlap = footprint(one.box).intersection(footprint(other.box)).area
                    assert overlap < 0.01, (room.room.name, name, other_name)


def test_targets_of_the_policy_experiment(cast_rooms: dict[str, CastRoom]) -> None:
    room = cast_rooms["room_1"]
    first = next(item for item in room.room.items if item.label == "cabinet")
    cabinet, box = room.assets[first.name], room.layout.standing[first.name].box
    assert cabinet.doors >= 1 and box.bottom == pytest.approx(0)
    assert {joint.handle for joint in cabinet.joints} <= {"bar", "knob", "arch"}
    assert 0.3 <= cabinet.size[1] / cabinet.doors <= 0.5
    ahead = _camera(room)[1][:2, 3] - np.asarray(box.center)[:2]
    assert abs(np.arctan2(ahead[1], ahead[0]) - box.yaw) < np.deg2rad(30)
    assert any(asset.drawers >= 2 for k in (1, 2, 3) for asset in cast_rooms[f"room_{k}"].assets.values())


def _camera(room: CastRoom) -> tuple[np.ndarray, np.ndarray]:
    points = np.concatenate([corners(standing.box) for standing in room.layout.standing.values()])
    return frame(points, room.room.camera, 800, 600, 0.06)


def test_everything_is_in_the_picture(cast_rooms: dict[str, CastRoom]) -> None:
    for room in cast_rooms.values():
        intrinsics, world_from_camera = _camera(room)
        points = np.concatenate([corners(standing.box) for standing in room.layout.standing.values()])
        pixels = project(transform_points(invert_transform(world_from_camera), points), intrinsics)
        assert pixels.min() >= 0.05 * 600 and (pixels.max(axis=0) <= 0.95 * np.array([800, 600])).all()
        tilt = np.rad2deg(np.arcsin(-world_from_camera[2, 2]))
        assert 10 <= tilt <= 25, (room.room.name, tilt)
        assert 1.3 <= world_from_camera[2, 3] <= 2.0


def test_every_object_is_seen(cast_rooms: dict[str, CastRoom]) -> None:
    """Ray-traced as boxes: each covers some pixels of the default picture, and most of it is not behind others."""
    for room in cast_rooms.values():
        intrinsics, world_from_camera = _camera(room)
        u, v = np.meshgrid(np.arange(0, 800, 4), np.arange(0, 600, 4))
        rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(intrinsics).T @ world_from_camera[:3, :3].T
        hits = [hit_box(world_from_camera[:3, 3], rays, one.box) for one in room.layout.standing.values()]
        nearest, seen = np.argmin(hits, axis=0), np.isfinite(np.min(hits, axis=0))
        for index, (name, hit) in enumerate(zip(room.layout.standing, hits, strict=True)):
            visible = ((nearest == index) & seen).sum()
            assert 16 * visible >= MIN_PIXELS, (room.room.name, name, visible)
            assert visible >= 0.4 * np.isfinite(hit).sum(), (room.room.name, name)


def test_same_seed_same_rooms_and_single_jobs_agree() -> None:
    models = default_models(0)
    everything, first_two = cast(ROOMS, models, 5, NOWHERE), cast(ROOMS[:2], models, 5, NOWHERE)
    for name in ("room_1", "room_2"):
        assert everything[name].assets == first_two[name].assets
        for item, standing in everything[name].layout.standing.items():
            np.testing.assert_array_equal(standing.box.center, first_two[name].layout.standing[item].box.center)
    assert cast(ROOMS, models, 6, NOWHERE)["room_8"].assets != everything["room_8"].assets


def test_a_larger_library_has_the_same_rooms() -> None:
    """Near relatives of other models play no part."""
    models = default_models(0)
    templates = {name: asset for name, asset in models.items() if asset.recipe and asset.recipe.variation_of is None}
    assert len(templates) < len(models)
    for name, room in cast(ROOMS, templates, 0, NOWHERE).items():
        assert {key: asset.id for key, asset in cast(ROOMS, models, 0, NOWHERE)[name].assets.items()} == {
            key: asset.id for key, asset in room.assets.items()
        }


def test_a_short_category_is_named() -> None:
    models = {name: asset for name, asset in default_models(0).items() if asset.category != "fridge"}
    with refused("E-MODELS-SHORT", "assets.counts.fridge"):
        cast(ROOMS, models, 0, NOWHERE)


def item(name: str, **place: object) -> Item:
    return Item.model_validate({"name": name, "category": name, "label": name, "place": place})


def test_places_of_a_small_room() -> None:
    items = (
        item("a", against="left", along=1.0, gap=0.0),
        item("b", beside="a", side="left", gap=0.1),
        item("c", on_top="a", forward=1.0),
        item("d", floor=(4.0, 1.5), yaw=90),
        item("e", on_top="a", forward=1.0, right=1.0, yaw=90),
    )
    room = RoomPlan(name="test", scale=4.0, items=items, walls=("back", "left"), half_width=2.0)
    sizes = {
        "a": (0.6, 1.0, 0.8),
        "b": (0.4, 0.5, 0.5),
        "c": (0.2, 0.2, 0.2),
        "d": (0.5, 0.5, 0.5),
        "e": (0.2, 0.4, 0.1),
    }
    layout = arrange(room, sizes)
    assert layout is not None
    a, b, c, e = (layout.standing[name].box for name in "abce")
    assert a.yaw == pytest.approx(np.pi / 2)
    assert np.asarray(a.center)[1] == pytest.approx(-layout.half_width + 0.3)  # its back is at the wall
    np.testing.assert_allclose(np.asarray(b.center)[0] - np.asarray(a.center)[0], 0.85)  # left of it, facing the wall
    np.testing.assert_allclose(np.asarray(c.center) - a.center, [0, 0.2, 0.5], atol=1e-9)  # at the front edge, on top
    across = np.abs(np.asarray(e.center) - a.center)
    np.testing.assert_allclose(across, [0.4, 0.1, 0.45], atol=1e-9)  # in the corner, none of it over an edge
    assert arrange(room, sizes | {"c": (0.9, 0.9, 0.9)}) is None  # sticks out over the edge


ATTIC = yaml.safe_load(re.findall(r"```yaml\n(# attic.*?)```", (ROOT / "docs/scenes.md").read_text(), re.DOTALL)[0])


def attic(tmp_path: Path, *changes: tuple[list[str | int], object]) -> Path:
    """The room of the documentation, with some entries changed (None: taken out)."""
    content = copy.deepcopy(ATTIC)
    for (*parents, key), value in changes:
        entry = content
        for part in parents:
            entry = entry[part]
        entry[key] = value
        if value is None:
            del entry[key]
    path = tmp_path / "attic.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


def test_a_room_is_read_from_yaml(tmp_path: Path) -> None:
    room = read_room(attic(tmp_path))
    assert room.name == "attic" and [type(item.place) for item in room.items] == [Against, On, Floor]
    assert room.items[0].model.drawers == (2, 6)
    assert list(room_files([str(tmp_path / "attic.yaml")])) == [*(f"room_{k}" for k in range(1, 9)), "attic"]
    (layout,) = cast([room], default_models(0), 3, NOWHERE).values()
    assert set(layout.assets) == {"chest", "lamp", "stool"}


@pytest.mark.parametrize(
    ("where", "value", "message"),
    [
        (["scale"], None, "scale: Field required"),
        (["scale"], -1, "scale: Input should be greater than 0"),
        (["walls"], ["front"], "walls.0"),
        (["color"], "red", "color: Extra inputs"),
        (["items"], [], "items: Tuple should have at least 2"),
        (["items", 0, "place"], {"at": "back"}, "items.0.place: needs one of against, beside, floor, on_top, hung"),
        (["items", 0, "place", "against"], "right", "'chest' is at the right wall, which is not one of walls"),
        (["items", 1, "place", "on_top"], "table", "'lamp' refers to 'table', which is no item before it"),
        (["items", 1, "name"], "chest", "two items are called 'chest'"),
        (["items", 0, "model", "width"], [2, 1], "items.0.model.width: 2 is above 1"),
        (["items", 2, "place"], {"beside": "lamp", "side": "left"}, "'lamp', which does not stand at a wall"),
        (["name"], "cellar", "its name is that of the file"),
    ],
)
def test_a_broken_room_is_one_clear_line(tmp_path: Path, where: list[str | int], value: object, message: str) -> None:
    path = attic(tmp_path, (where, value))
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        read_room(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_unreadable_rooms_and_names_that_are_taken(tmp_path: Path) -> None:
    (tmp_path / "attic.yaml").write_text("items: [")
    with refused("E-ROOM-FILE") as caught:
        read_room(tmp_path / "attic.yaml")
    assert "\n" not in str(caught.value)
    (tmp_path / "room_1.yaml").write_text("scale: 1")
    with refused("E-ROOM-NAME"):
        room_files([str(tmp_path / "room_1.yaml")])
    with refused("E-ROOM-MISSING"):
        room_files(["nowhere.yaml"])


def test_a_room_that_no_models_left_fit_has_some_of_other_rooms(capsys: pytest.CaptureFixture[str]) -> None:
    seed = 214749  # of whose models those left over fit room_5 in no way
    rooms = cast(ROOMS, default_models(seed), seed, NOWHERE)
    used = [asset.id for room in rooms.values() for asset in room.assets.values()]
    assert len(rooms) == 8 and len(set(used)) == len(used) - 1
    assert "room_5: no models that are left fit its layout" in capsys.readouterr().err
