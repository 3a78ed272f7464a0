"""Matching by renderings in the object's place: what is laid over, seen, compared, and when nobody can tell."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh
from PIL import Image

from roomkin.plugins.pictures.cousins import write_picture
from roomkin.plugins.render_and_compare.fits import (
    Measured,
    color_agreement,
    compare,
    lay_over,
    line_agreement,
    line_field,
    measure,
    outline_agreement,
)
from roomkin.plugins.render_and_compare.in_place import InPlace
from roomkin.plugins.render_and_compare.judges.geometry import MIN_FIT
from roomkin.plugins.render_and_compare.judges.geometry import Judge as Geometry
from roomkin.plugins.render_and_compare.judges.rerender import Judge as Rerender
from roomkin.plugins.render_and_compare.observation import NoisyCloud, ObservedGrid, free_sides, observe
from roomkin.plugins.render_and_compare.package import GeometryConfig
from roomkin.plugins.render_and_compare.rendering import ColoredSolid, Rendering, render
from roomkin.stages.articulated.asset_folder import Description, write_asset
from roomkin.stages.articulated.model import Link, RobotModel, Visual
from roomkin.stages.config.matching import matching_model
from roomkin.stages.contracts import Cousins, Library, LibraryPart, Objects, read_json, write_json
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.contracts.library_folder import write_part
from roomkin.stages.contracts.objects import USUAL_ERROR, Box, Mounting, SceneObject, Wall
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.frames import intrinsics_from_fov, look_at, make_transform, wrap_angle, yaw_matrix
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.judges import AbstainedError, Question
from roomkin.stages.matching.snapshots import Snapshots
from tests.unit.matching_data import trace_box, write_snapshots

Options: Any = matching_model(["render_and_compare"])
SIZE = (0.4, 1.0, 0.8)
SIDE, EYE = 160, (3.0, 0.3, 1.2)
POSE = look_at(EYE, [0, 0, 0])
INTRINSICS = intrinsics_from_fov(SIDE, SIDE, 0.6)


def striped(plate: trimesh.Trimesh) -> Visual:
    """The plate with a texture of stripes across."""
    stripes = np.repeat(np.array([[40, 220] * 8], np.uint8).T, 2, axis=1)[..., None].repeat(3, axis=2)
    uv = np.stack([plate.vertices[:, 1], plate.vertices[:, 2]], axis=1)
    material = trimesh.visual.material.SimpleMaterial(image=Image.fromarray(stripes))
    plate.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return Visual(plate)


def write_model(folder: Path, panels: tuple[int, int], size: Sequence[float] = SIZE, textured: bool = False) -> None:
    """A box with a dark front on which light panels stand, as `trace_box` draws it."""
    body = trimesh.creation.box(size)
    pieces = [Visual(body, (0.2, 0.2, 0.2, 1.0))]
    width, height = size[1] / panels[0], size[2] / panels[1]
    dark = trimesh.creation.box((0.002, size[1], size[2]), make_transform(np.eye(3), np.array([size[0] / 2, 0, 0])))
    pieces.append(Visual(dark, (0.03, 0.03, 0.03, 1.0)))
    for column in range(panels[0]):
        for row in range(panels[1]):
            at = [size[0] / 2 + 0.002, (column + 0.5) * width - size[1] / 2, (row + 0.5) * height - size[2] / 2]
            plate = trimesh.creation.box((0.002, 0.88 * width, 0.88 * height), make_transform(np.eye(3), np.array(at)))
            pieces.append(striped(plate) if textured else Visual(plate, (0.3, 0.3, 0.3, 1.0)))
    link = Link("body", pieces, [body], 5.0, np.zeros(3), np.eye(3))
    write_asset(RobotModel(folder.name, {"body": link}), folder, Description(folder.name, "cabinet", "CC0-1.0", "test"))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    models = {"two": (2, 1), "three": (3, 1), "stack": (1, 4)}
    for name, panels in models.items():
        write_model(folder / name, panels)
    write_model(folder / "striped", (2, 1), textured=True)
    models["striped"] = (2, 1)
    write_part(folder / "part.json", folder)
    unseen = LibraryEntry(id="unseen", category="cabinet", archive="unseen.zip", doors=0, drawers=0, checksum="0")
    write_json(folder / "library.json", Library(assets=[*read_json(LibraryPart, folder / "part.json").assets, unseen]))
    return folder / "library.json"


def question(library: Path, yaw: float, panels: tuple[int, int] = (2, 1), **changes: object) -> Question:
    """A box of SIZE at the origin, turned by `yaw`; the floor frame is the world."""
    rgb, depth = trace_box(SIZE, yaw, panels, POSE, INTRINSICS, SIDE, SIDE)
    view = ObjectView(rgb, depth > 0, depth, INTRINSICS, POSE[:3, :3].T @ np.array([0.0, 0.0, 1.0]))
    box = Box(center=(0, 0, 0), size=SIZE, yaw=wrap_angle(yaw, np.pi / 2))
    item = SceneObject(id="cabinet_1", label="cabinet", mask=1, box=box, mounting=Mounting(type=2))
    scene = Objects(
        scene="test",
        width=SIDE,
        height=SIDE,
        intrinsics=INTRINSICS.tolist(),
        floor_from_camera=POSE.tolist(),
        walls=[],
        objects=[item],
    )
    view = replace(view, **changes)  # type: ignore[arg-type]
    return Question(view, "cabinet", library, Snapshots(()), f"test/{yaw}/{panels}", item=item, scene=scene)


def candidates(*names: str) -> list[Candidate]:
    return [Candidate(asset=name, category="cabinet", distance=1.0) for name in names]


def views(*yaws: float) -> list[Orientation]:
    return [Orientation(yaw=yaw, distance=1.0) for yaw in yaws]


TOWARDS = float(np.arctan2(EYE[1], EYE[0]))  # of a model whose front faces the camera


def test_a_model_is_seen_where_it_stands(library: Path) -> None:
    """Rays against the ray tracer: the same outline, the same depth."""
    yaw = 0.4
    asked = question(library, yaw)
    seen = observe(asked.view, POSE, USUAL_ERROR, SIDE)
    shown = render(ColoredSolid(library.parent / "two"), UprightBox((0, 0, 0), SIZE, yaw), seen)
    assert outline_agreement(seen, shown, 1.0) > 0.97
    both = seen.mask & (shown.cover == 1)
    np.testing.assert_allclose(shown.depth[both], seen.depth[both], atol=0.02)


def test_a_box_is_laid_over_the_object(library: Path) -> None:
    """From a box that is far too small and off its place to the outline, as far as its sides are seen."""
    seen = observe(question(library, 0.4).view, POSE, USUAL_ERROR, SIDE)
    solid, extents = ColoredSolid(library.parent / "two"), np.array(SIZE)
    ends = np.array([-0.38 * extents, 0.5 * extents])
    measured = Measured(ends, np.array([0.3 * extents, 0.1 * extents]), 0.4)
    fitted = lay_over(solid, measured, seen)
    before, after = (outline_agreement(seen, render(solid, box, seen), 1.0) for box in (measured.box(), fitted))
    assert before < 0.85 < 0.94 < after


def test_a_mask_that_lacks_its_lower_part_squeezes_nothing(library: Path) -> None:
    """People and networks lose legs; the box was measured down to what the object stands on."""
    asked = question(library, 0.4)
    mask = asked.view.mask.copy()
    mask[np.flatnonzero(mask.any(axis=1))[-mask.any(axis=1).sum() // 3 :]] = False
    seen = observe(replace(asked.view, mask=mask), POSE, USUAL_ERROR, SIDE)
    assert seen.free.all()
    ends = np.array([-0.5 * np.array(SIZE), 0.5 * np.array(SIZE)])
    fitted = lay_over(ColoredSolid(library.parent / "two"), Measured(ends, np.full((2, 3), 0.03), 0.4), seen)
    np.testing.assert_allclose(fitted.size, SIZE, rtol=0.05)


def test_only_what_a_quarter_turn_leaves_alike_stays_square(library: Path) -> None:
    """A desk turned by half looks the same and may be deeper than another; a square table is as deep as it is wide."""
    seen = observe(question(library, 0.4).view, POSE, USUAL_ERROR, SIDE)
    seen = replace(seen, free=np.zeros(4, bool))  # its outline, hidden all around, tells nothing
    ends = np.array([-0.5, 0.5])[:, None] * [0.8, 1.0, 0.8]  # twice as deep as the model
    stretches = {}
    for symmetry in ("none", "half_turn", "quarter_turn"):
        solid = ColoredSolid(library.parent / "two")
        solid.asset = solid.asset.model_copy(update={"symmetry": symmetry})
        x, y, _ = lay_over(solid, Measured(ends, np.full((2, 3), 0.1), 0.4), seen).size / SIZE
        stretches[symmetry] = x / y
    assert stretches["half_turn"] == stretches["none"] > 1.5 and stretches["quarter_turn"] < 1.2


@pytest.mark.parametrize("yaw", [0.3, 1.0, -0.8, 0.3 + np.pi])
def test_a_box_fits_best_at_its_own_yaw(library: Path, yaw: float) -> None:
    """Also seen from behind: no panels there."""
    judge = Geometry(Options())
    best, *rest = judge.orientations(question(library, yaw), "two", [], views(0.0, 2.0))
    assert wrap_angle(best.yaw - (yaw - TOWARDS)) == pytest.approx(0, abs=0.03)
    assert best.distance is None and best.score == max(one.score for one in (best, *rest))
    assert len(rest) == 5  # three quarter turns, and two views


def test_panels_tell_models_apart(library: Path) -> None:
    judge = Geometry(Options(geometry=GeometryConfig(nearest=3)))
    given = candidates("stack", "three", "two", "unseen")
    for name, panels in (("two", (2, 1)), ("three", (3, 1)), ("stack", (1, 4))):
        ranked = judge.models(question(library, 0.3, panels), [], given)
        assert ranked[0].asset == name
        assert ranked[-1].asset == "unseen"  # beyond the nearest: by distance
        scores = [one.score for one in ranked[:-1]]
        assert None not in scores and scores == sorted(scores, reverse=True) and ranked[-1].score is None
        assert set(ranked[0].terms) == {"outline", "depth", "lines", "colour", "proportions", "priors"}


def test_where_nothing_fits_only_what_is_known_counts(library: Path) -> None:
    """Every third column of the mask: outlines that no model has."""
    judge, asked = Geometry(Options()), question(library, 0.3)
    given = [
        Candidate(asset="three", category="cabinet", distance=1.0, parts={"size": 0.0}),
        Candidate(asset="two", category="cabinet", distance=1.0, parts={"size": 0.01}),
    ]
    assert [one.asset for one in judge.models(asked, [], given)] == ["two", "three"]
    torn = asked.view.mask & (np.arange(SIDE) % 3 == 0)
    ranked = judge.models(question(library, 0.3, mask=torn)._replace(name="torn"), [], given)
    assert [(one.asset, one.score) for one in ranked] == [("three", 0.0), ("two", -0.01)]
    assert ranked[0].terms["outline"] < 0.6


def test_whether_it_fits_is_asked_of_what_would_come_first(library: Path) -> None:
    """`two` has the lines that are seen, but its size is known to be another: `stack`, first by both, does not fit."""
    judge = Geometry(Options(geometry=GeometryConfig(outline=0, depth=0, lines=1)))
    given = [
        Candidate(asset="two", category="cabinet", distance=1.0, parts={"size": 2.0}),
        Candidate(asset="stack", category="cabinet", distance=1.0, parts={"size": 0.0}),
    ]
    ranked = judge.models(question(library, 0.3), [], given)
    lines = {one.asset: one.terms["lines"] for one in ranked}
    assert lines["stack"] < MIN_FIT < lines["two"]
    assert [(one.asset, one.score) for one in ranked] == [("stack", 0.0), ("two", -2.0)]


def test_textures_and_patches_count_for_nothing_priors_do(library: Path) -> None:
    """The finish of a library's model is not the object's: only its parts may be seen in the lines."""
    judge, asked = Geometry(Options()), question(library, 0.3)
    near, far = {"patches": 0.5, "size": 0.0}, {"patches": 1.5, "size": 0.0}
    given = [
        Candidate(asset="three", category="cabinet", distance=0.5, parts=near),
        Candidate(asset="striped", category="cabinet", distance=1.5, parts=far),
    ]
    assert judge.models(asked, [], given)[0].asset == "striped"
    unlike = given[1].model_copy(update={"parts": {"patches": 0.5, "size": 1.0}})
    assert judge.models(asked, [], [given[0], unlike])[0].asset == "three"
    seen = observe(asked.view, POSE, USUAL_ERROR, SIDE)
    shown = [
        render(ColoredSolid(library.parent / name), UprightBox((0, 0, 0), SIZE, 0.3), seen)
        for name in ("two", "striped")
    ]
    plain, textured = (line_agreement(line_field(seen.rgb), line_field(one.plain), seen.mask) for one in shown)
    assert textured == pytest.approx(plain, abs=0.03)
    assert line_agreement(line_field(seen.rgb), line_field(shown[1].rgb), seen.mask) < plain - 0.1


def test_what_is_hidden_or_cut_off_does_not_count(library: Path) -> None:
    """Something nearer covers the left third: the outline is compared where it can be seen, that side is not fitted."""
    asked = question(library, 0.3)
    columns = np.flatnonzero(asked.view.mask.any(axis=0))
    covered = np.zeros_like(asked.view.mask)
    covered[:, : columns[0] + len(columns) // 3] = True
    assert asked.view.depth is not None
    view = replace(asked.view, mask=asked.view.mask & ~covered, depth=np.where(covered, 1.0, asked.view.depth))
    assert view.depth is not None
    assert free_sides(view.mask, view.depth, USUAL_ERROR).tolist() == [False, True, True, True]
    solid, box = ColoredSolid(library.parent / "two"), UprightBox((0, 0, 0), SIZE, 0.3)
    seen = observe(view, POSE, USUAL_ERROR, SIDE)
    assert outline_agreement(seen, render(solid, box, seen), 1.0) > 0.95
    open_space = observe(replace(view, depth=np.where(covered, 9.0, view.depth)), POSE, USUAL_ERROR, SIDE)
    assert outline_agreement(open_space, render(solid, box, open_space), 1.0) < 0.85


@pytest.mark.parametrize("judge", [Geometry, Rerender])
def test_nobody_decides_without_depth_pixels_or_models(library: Path, judge: type) -> None:
    asked = question(library, 0.3)
    assert asked.view.depth is not None
    few = np.zeros_like(asked.view.mask)
    few[80:84, 80:84] = True
    for changed, reason in (
        (asked._replace(view=replace(asked.view, depth=None)), "depth"),
        (asked._replace(view=replace(asked.view, depth=np.zeros_like(asked.view.depth))), "depth"),
        (asked._replace(view=replace(asked.view, mask=few)), "16 pixels"),
        (asked._replace(item=None), "no box"),
    ):
        with pytest.raises(AbstainedError, match=reason):
            judge(Options()).orientations(changed, "two", [], views(0.0))
    with pytest.raises(AbstainedError, match=r"no unseen.zip beside library\.json"):
        judge(Options()).orientations(asked, "unseen", [], views(0.0))


def test_views_are_rendered_again_and_ordered_by_their_distance(library: Path) -> None:
    """Only the k_ori nearest; the right one is nearest to the object once it has its shape and its direction."""
    yaw = 0.3
    right = wrap_angle(yaw - TOWARDS)
    given = views(right + np.pi, right + np.pi / 2, right, right - np.pi / 2, right + 0.1)
    answer = Rerender(Options(k_ori=4)).orientations(question(library, yaw), "two", [], given)
    assert answer[0].yaw == right and len(answer) == 4
    assert answer[0].distance < 0.8 * answer[1].distance
    assert Rerender(Options()).models(question(library, yaw), [], candidates("three", "two"))[0].asset == "three"


@pytest.mark.parametrize(
    "known",
    [
        {"front": 0.3 - np.pi},
        {"mounting": Mounting(type=1, walls=["rear"])},
        {"mounting": Mounting(type=3, walls=["rear"])},
    ],
)
def test_where_the_front_is_known_no_other_way_to_stand_is_compared(library: Path, known: dict[str, Any]) -> None:
    """The picture shows a front of two panels; by the input, or the wall before it, that is the rear."""
    asked = question(library, 0.3)
    assert asked.item is not None and asked.scene is not None
    away = -yaw_matrix(0.3)[:, 0]
    wall = Wall(id="rear", normal=tuple(away), offset=-0.2, points=9)
    scene = asked.scene.model_copy(update={"walls": [wall]})
    told = asked._replace(name="told", item=asked.item.model_copy(update=known), scene=scene)
    judge = Geometry(Options())
    (only,) = judge.orientations(told, "two", [], views(0.0, 1.0))
    assert only.yaw == pytest.approx(wrap_angle(0.3 + np.pi - TOWARDS))
    all_of_them = Rerender(Options(k_ori=2)).orientations(told, "two", [], views(0.0, 1.0))
    assert len(all_of_them) == 2, "the paper asks the picture alone"
    (best,) = judge.models(told, [], candidates("two"))
    assert best.terms["lines"] == only.terms["lines"] < judge.models(asked, [], candidates("two"))[0].terms["lines"]


def test_extents_are_measured_along_the_axes() -> None:
    """Ends behind the object, noise and a wall further back make errors; noise is taken off along the line of sight."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (0, 1)], float) / 2
    cloud = corners @ yaw_matrix(0.5).T + [4, 2, 0]
    away, across = yaw_matrix(0.5)[:, 0], yaw_matrix(0.5)[:, 1]
    eye = np.array([4, 2, 1]) - 4 * away
    sight, whole = NoisyCloud(cloud, eye, USUAL_ERROR.predict), UprightBox([4, 2, 0.25], [1, 2, 0.5], 0.5)
    seen = measure(sight, whole, 0.5)
    box = seen.box()
    off = 2 * (0.003 + 0.0015 * 4**2)  # 2 deviations at either end
    np.testing.assert_allclose(box.size, [1 - 2 * off, 2, 0.5], atol=0.01)
    np.testing.assert_allclose(box.center, [4, 2, 0.25], atol=0.02)
    assert seen.errors[1, 0] > 2 * seen.errors[0, 0] and abs(seen.errors[0, 1] - seen.errors[1, 1]) < 0.01
    wall = measure(sight, whole, 0.5, (-away, -float(away @ [4, 2, 0]) - 0.9))
    assert wall.ends[1, 0] - seen.ends[1, 0] == pytest.approx(0.4 + off, abs=0.005)
    assert wall.errors[1, 0] == pytest.approx(0.1 * 0.9 + 0.225, abs=0.03)
    before = measure(sight, whole, 0.5, (-away, -float(away @ [4, 2, 0]) + 0.9))  # nearer than the near end
    assert before.ends[1, 0] == seen.ends[0, 0] and before.errors[1, 0] == seen.errors[0, 0]
    assert (wall.ends[:, 1:] == seen.ends[:, 1:]).all() and across @ box.center == pytest.approx(
        across @ [4, 2, 0], abs=0.03
    )


def test_cousins_are_drawn_in_the_objects_place(library: Path, tmp_path: Path) -> None:
    asked = question(library, 0.3)
    scene: Any = SimpleNamespace(view=lambda item: asked.view, objects=asked.scene)
    in_place = InPlace(scene, library)
    right, turned = (
        Cousin(rank=1, **candidates("two")[0].model_dump(), orientation=view, orientations=[view])
        for view in views(wrap_angle(0.3 - TOWARDS), wrap_angle(0.3 + np.pi - TOWARDS))
    )
    assert asked.item is not None
    shown, other = in_place.show(asked.item, right), in_place.show(asked.item, turned)
    assert shown is not None and other is not None
    assert shown[0].dtype == np.uint8 and shown[0].shape == other[0].shape
    front, back = ((picture < 60).all(axis=-1).sum() for picture, _ in (shown, other))
    assert front > 2 * back  # the dark gaps between panels
    assert shown[1].startswith("outl. 0.9") and shown[1] != other[1]
    assert in_place.show(asked.item, right.model_copy(update={"asset": "unseen"})) is None
    assert asked.scene is not None
    found = ObjectCousins(id="cabinet_1", label="cabinet", cousins=[right])
    shard = write_snapshots(tmp_path / "shard.h5", ["two"], {"two": ("cabinet", SIZE, (2, 1), 2, 0)})
    heights = []
    for show in (None, in_place.show):
        write_picture(tmp_path / "a.png", Cousins(scene="test", encoder="hog", objects=[found]), scene, [shard], show)
        heights.append(Image.open(tmp_path / "a.png").height)
    assert heights[1] > 1.5 * heights[0]  # a row more


def test_textures_are_seen_where_they_lie(tmp_path: Path) -> None:
    """A square with a picture, its upper half white: seen from the front, above is light and below is dark."""
    body = trimesh.creation.box((0.2, 0.01, 0.2))  # behind it
    plate = trimesh.Trimesh(
        [[0.1, y, z] for y in (-0.5, 0.5) for z in (-0.5, 0.5)], [[0, 2, 1], [1, 2, 3]], process=False
    )
    image = Image.fromarray(np.repeat(np.array([[255, 0]], np.uint8).T, 2, axis=1)[..., None].repeat(3, axis=2))
    uv = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    plate.visual = trimesh.visual.TextureVisuals(uv=uv, material=trimesh.visual.material.SimpleMaterial(image=image))
    link = Link("body", [Visual(plate), Visual(body, (0.5, 0.5, 0.5, 1.0))], [body], 1.0, np.zeros(3), np.eye(3))
    write_asset(RobotModel("sign", {"body": link}), tmp_path / "sign", Description("sign", "sign", "CC0-1.0", "test"))
    solid = ColoredSolid(tmp_path / "sign")
    box = UprightBox((0, 0, 0), solid.asset.size, 0.0)
    rays = np.array([[-2.0, y, z] for z in (0.3, -0.3) for y in (0.2, -0.2)])
    hits = solid.cast_rays(np.array([2.0, 0.0, 0.0]), rays, box)
    np.testing.assert_allclose(hits.color[:, 0], [1, 1, 0, 0], atol=0.02)
    np.testing.assert_allclose(hits.plain, 0.5, atol=0.02)
    np.testing.assert_allclose(hits.depth, 0.95, atol=0.01)
    np.testing.assert_allclose(hits.normals, [[1, 0, 0]] * 4, atol=1e-5)


def test_another_light_is_no_other_color() -> None:
    lab = np.array([[60, 20, -10], [50, 0, 30], [55, 10, 10]], np.float32)
    given, dark, hue = (
        cv2.cvtColor((lab + np.array(shift, np.float32))[None], cv2.COLOR_LAB2RGB)[0]
        for shift in ((0, 0, 0), (-25, 0, 0), (0, 15, 0))
    )
    assert color_agreement(given, hue) < 0.9 and color_agreement(given, dark) > 0.99


def test_an_error_of_the_depths_scale_is_no_misfit() -> None:
    depth = np.linspace(2.0, 2.4, 30, dtype=np.float32)[None].repeat(20, axis=0)
    grey, mask = np.full((20, 30, 3), 0.5, np.float32), np.ones((20, 30), bool)
    nothing = np.zeros(0)
    shown = Rendering(grey, grey, mask.astype(np.float32), depth)

    def misfit(seen_depth: np.ndarray) -> float:
        seen = ObservedGrid(
            np.eye(4), np.eye(3), grey, mask, seen_depth, USUAL_ERROR, mask, nothing, 1.0, nothing, mask[0], nothing
        )
        return compare(seen, shown, (0.4, 0.4, 0.4), (0.4, 0.4, 0.4), line_field(grey))[1]

    right, scaled, turned = misfit(depth), misfit(1.2 * depth), misfit(depth[:, ::-1].copy())
    assert right > 0.99 and scaled > 0.97 and turned < 0.8
