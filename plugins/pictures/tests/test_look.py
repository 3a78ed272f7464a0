"""The look of a room: light and colors of a picture that was drawn with known ones are found again."""

from typing import Any

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.plugins.pictures.look import (
    SeenPixels,
    estimate_light,
    estimate_look,
    find_bounds,
    find_surfaces,
    furnish,
    merge_meshes,
    to_direction,
)
from roomkin.stages.contracts import GeneratedScene, Objects
from roomkin.stages.contracts.generated import ROOM_LIGHT, Look, Surface
from roomkin.stages.contracts.objects import Mounting, SceneObject, Wall
from roomkin.stages.generation.placed import Placed
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at
from roomkin.stages.simulation.rendering import RenderCamera, instance_id
from roomkin.stages.simulation.room import WALL_HEIGHT

WIDTH, HEIGHT = 200, 150
WALL = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=99)  # the plane x = 4
FLOOR_COLOR, WALL_COLOR = (0.5, 0.3, 0.15), (0.3, 0.45, 0.6)


@pytest.fixture(scope="module")
def items(tmp_path_factory: pytest.TempPathFactory) -> list[Placed]:
    """A cabinet at the wall, and before it a table."""
    folder = tmp_path_factory.mktemp("furniture")
    items = []
    for name, center in (("bottom_cabinet", (3.6, 0.6)), ("coffee_table", (2.6, -0.5))):
        asset = build(sample(name, 0, 0), None, folder / name, name, name)
        box = UprightBox((*center, asset.size[2] / 2), asset.size, np.pi)
        items.append(Placed(name, name, asset, folder / name, box, Mounting(type=2)))
    return items


def objects_of(items: list[Placed], away: float = 0.0) -> Objects:
    """The view of a camera `away` metres farther behind."""
    found = [
        SceneObject(id=item.id, label=item.label, mask=mask, status="failed", reason="not looked at")
        for mask, item in enumerate(items, start=1)
    ]
    return Objects(
        scene="t",
        width=WIDTH,
        height=HEIGHT,
        intrinsics=intrinsics_from_fov(WIDTH, HEIGHT, 0.9).tolist(),
        floor_from_camera=look_at([-away, 0, 1.5], [3, 0, 0.4]).tolist(),
        walls=[WALL],
        objects=found,
    )


def scene_of(objects: Objects) -> GeneratedScene:
    fields = ("scene", "width", "height", "intrinsics", "floor_from_camera", "walls")
    return GeneratedScene(variant="default", rank=1, objects=[], **{name: getattr(objects, name) for name in fields})


def true_look(light: Any) -> Look:
    return Look(
        light=tuple(light),
        light_from="shadows",
        shadow_correlation=1.0,
        surfaces=[
            Surface(id="floor", colour=FLOOR_COLOR, low=(0, -3), high=(4, 3)),
            Surface(id="wall_1", colour=WALL_COLOR, low=(-4, 0), high=(4, 3)),
        ],
    )


def taken(objects: Objects, items: list[Placed], look: Look) -> tuple[Any, Any, Any]:
    """Picture, masks and depth of the furniture in a look."""
    scene = furnish(scene_of(objects), items, look)
    picture = RenderCamera(scene, objects.intrinsics, WIDTH, HEIGHT).render(objects.floor_from_camera)
    blocks = [instance_id(entity) for entity in scene.entities if entity.name in ("floor", "wall_1")]
    masks = np.where(np.isin(picture.segmentation, [0, *blocks]), 0, 1).astype(np.uint16)
    return picture.rgb, masks, picture.depth


@pytest.mark.parametrize(("azimuth", "elevation"), [(50, 50), (-35, 40), (10, 60)])
def test_light_and_colors_are_found_again(items: Any, azimuth: float, elevation: float) -> None:
    objects, light = objects_of(items), to_direction(np.radians(azimuth), np.radians(elevation))
    pictures = taken(objects, items, true_look(light))
    look = estimate_look(objects, pictures, scene_of(objects), items)
    assert look.light_from == "shadows" and look.shadow_correlation > 0.6
    assert np.degrees(np.arccos(light @ look.light)) < 8
    found = {surface.id: surface.colour for surface in look.surfaces}
    assert found["floor"] == pytest.approx(FLOOR_COLOR, abs=0.03)
    assert found["wall_1"] == pytest.approx(WALL_COLOR, abs=0.03)
    again = taken(objects, items, look)[0]
    assert np.abs(again.astype(int) - pictures[0]).mean() < 2.5  # of 255


def test_a_picture_without_shadows_gets_the_light_that_all_such_have(items: Any) -> None:
    objects = objects_of(items)
    rgb, masks, depth = taken(objects, items, true_look(to_direction(0.8, 0.8)))
    noise = np.random.default_rng(0).integers(150, 160, rgb.shape).astype(np.uint8)
    look = estimate_look(objects, (noise, masks, depth), scene_of(objects), items)
    assert look.light_from == "default"
    assert np.cross(look.light, ROOM_LIGHT) == pytest.approx(np.zeros(3), abs=1e-5)


def test_light_comes_through_no_wall(items: Any) -> None:
    objects = objects_of(items)
    pictures = taken(objects, items, true_look(to_direction(0.8, 0.8)))
    seen = find_surfaces(*pictures, objects)
    backwards = {name: one for name, one in seen.items() if name == "floor"}
    darkened = backwards["floor"].rgb.copy()
    darkened[backwards["floor"].points[:, 0] < 2.2] = 0.1  # as if light came through the wall x = 4
    for one in seen.values():
        one.rgb[...] = darkened if len(one.rgb) == len(darkened) else one.rgb
    assert estimate_light(backwards, merge_meshes(items))[0][0] < 0
    assert estimate_light(seen, merge_meshes(items))[0][0] >= 0


def test_only_what_lies_in_its_plane_is_a_surface(items: Any) -> None:
    objects = objects_of(items)
    rgb, masks, depth = taken(objects, items, true_look(to_direction(0.8, 0.8)))
    whole = find_surfaces(rgb, masks, depth, objects)
    assert set(whole) == {"floor", "wall_1"}
    assert np.abs(whole["floor"].points[:, 2]).max() < 1e-9
    assert whole["wall_1"].points[:, 0] == pytest.approx(4.0)
    unknown = find_surfaces(rgb, np.zeros_like(masks), depth, objects)  # nothing masked: the depth tells furniture
    grown = {name: len(unknown[name].points) - len(whole[name].points) for name in whole}
    assert 0 <= max(grown.values()) < 0.2 * (masks > 0).sum()
    assert not find_surfaces(rgb, masks, np.zeros_like(depth), objects)  # no depth anywhere: nothing is known


def test_shadows_fall_far_from_the_camera_too(items: Any) -> None:
    """The floor frame's origin is below the camera: the shadow map must follow the furniture."""
    moved = [item.shift([12, 0, 0]) for item in items]
    objects = objects_of(items).model_copy(update={"walls": []})
    objects.floor_from_camera = look_at([10, 0, 2.5], [15, 0, 0.2]).tolist()
    rgb, masks, depth = taken(objects, moved, true_look(to_direction(0.8, 0.8)))
    floor = rgb[(masks == 0) & (depth > 0)][:, 0].astype(float)
    assert (floor < 0.85 * np.median(floor)).mean() > 0.004  # none otherwise


def test_a_wall_is_seen_up_to_its_end_or_stands_to_the_height_of_a_room() -> None:
    height, across = (values.ravel() for values in np.meshgrid(np.linspace(0.3, 1.2, 40), np.linspace(-1, 1, 40)))
    points = np.column_stack([np.full(1600, 4.0), across, height])
    still = np.zeros(1600, int)
    highest = {}
    for above in (False, True):
        seen = SeenPixels(np.array([-1.0, 0, 0]), still, still, points, np.zeros((1600, 3)), above)
        (left, low), (right, highest[above]) = find_bounds("wall_1", seen)
        assert (left, right) == pytest.approx((-1.3, 1.3), abs=0.02) and low == 0  # it goes on a little at the border
    assert highest == {False: pytest.approx(1.2, abs=0.02), True: WALL_HEIGHT}
