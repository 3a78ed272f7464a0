"""Matching without pictures: the judge `priors`."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from roomkin.plugins.render_and_compare.judges.priors import Judge
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.contracts import Cousins, Objects, read_json
from roomkin.stages.contracts.cousins import Candidate, Orientation
from roomkin.stages.contracts.objects import Box, Mounting, SceneObject, Wall
from roomkin.stages.geometry.frames import angle_difference, make_transform, wrap_angle
from roomkin.stages.geometry.masks import ObjectView
from roomkin.stages.matching.judges import AbstainedError, Question
from roomkin.stages.matching.match import run as match
from roomkin.stages.matching.snapshots import Snapshots
from tests.refusals import refused
from tests.unit.matching_data import SHOWN, World

BLIND = {"model_selection": "priors", "orientation_selection": "priors"}
NOTHING = ObjectView(np.zeros((4, 4, 3), np.uint8), np.zeros((4, 4), bool))


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("blind"))


def question(mounting: Mounting, yaw: float = 0.0, box: bool = True) -> Question:
    """An object two metres before a camera above the origin that looks along x; the wall behind it faces the camera."""
    item = SceneObject(
        id="x_1",
        label="x",
        mask=1,
        box=Box(center=(2, 0, 0.5), size=(1, 1, 1), yaw=yaw) if box else None,
        mounting=mounting,
        **({} if box else {"status": "failed", "reason": "no points"}),
    )
    side = Wall(id="side", normal=(0, 1, 0), offset=-1, points=9)
    scene = Objects(
        scene="s",
        width=4,
        height=4,
        intrinsics=[[4.0, 0.0, 1.5], [0.0, 4.0, 1.5], [0.0, 0.0, 1.0]],
        floor_from_camera=make_transform(np.eye(3), [0.0, 0.0, 1.5]).tolist(),
        walls=[side],
        objects=[item],
    )
    return Question(NOTHING, "x", Path("nowhere"), Snapshots([]), item=item, scene=scene)


def turned(asked: Question, views: list[Orientation] | None = None) -> list[Orientation]:
    return Judge(MatchingConfig()).orientations(asked, "a", [], views or [Orientation(yaw=0, distance=0)])


def test_models_are_ordered_by_what_is_known_of_them_and_ties_by_id() -> None:
    found = [
        Candidate(asset=name, category="c", distance=patches + size, parts={"patches": patches, "size": size})
        for name, patches, size in (("c", 0.1, 0.5), ("b", 0.2, 0.3), ("a", 0.9, 0.3), ("d", 5.0, 0.1))
    ]
    ordered = Judge(MatchingConfig()).models(question(Mounting(type=2)), found[:1], found)
    assert [one.asset for one in ordered] == ["d", "a", "b", "c"]


def test_what_stands_at_a_wall_turns_its_front_away_from_it() -> None:
    best = turned(question(Mounting(type=3, walls=["side"]), yaw=0.3))[0]
    assert angle_difference(best.yaw + np.pi, np.pi / 2) < 1e-6  # seen along x, a yaw of 0 faces -x


@pytest.mark.parametrize("yaw", [-0.6, 0.0, 0.3, 0.78])
def test_what_stands_free_is_turned_along_its_box_with_its_front_to_the_camera(yaw: float) -> None:
    views = [view.yaw for view in turned(question(Mounting(type=2), yaw))]
    assert len(views) == 4 and abs(views[0]) <= np.pi / 4 and [abs(view) for view in views] == sorted(map(abs, views))
    assert all(abs(wrap_angle(view - yaw, np.pi / 2)) < 1e-6 for view in views)


def test_stored_views_say_nothing_not_even_one_of_the_same_yaw() -> None:
    views = [Orientation(yaw=2.0, distance=0.2), Orientation(yaw=0.0, distance=0.7)]
    found = turned(question(Mounting(type=2)), views)
    assert found[0] == Orientation(yaw=0.0) and all(view.distance is None for view in found)


def test_without_a_box_the_judge_abstains() -> None:
    with pytest.raises(AbstainedError, match="no box"):
        turned(question(Mounting(type=2), box=False))


def blind(world: World, folder: Path, out: Path, **options: object) -> Cousins:
    match(
        objects=folder / "objects.json",
        image=folder / "rgb.png",
        library=world.library,
        out=out,
        options=json.dumps(BLIND | options),
    )
    return read_json(Cousins, out)


def test_no_picture_is_looked_at(world: World, tmp_path: Path) -> None:
    """Neither features nor snapshots are given; a black picture and depth that is 0 everywhere give the same bytes."""
    found = blind(world, world.objects.parent, tmp_path / "seen.json")
    dark = tmp_path / "dark"
    dark.mkdir()
    for name in ("objects.json", "masks.png"):
        (dark / name).write_bytes((world.objects.parent / name).read_bytes())
    cv2.imwrite(str(dark / "rgb.png"), np.zeros_like(cv2.imread(str(world.objects.parent / "rgb.png"))))
    with np.load(world.objects.parent / "depth.npz") as depth:
        np.savez(dark / "depth.npz", depth=np.zeros_like(depth["depth"]))
    blind(world, dark, tmp_path / "dark.json")
    assert (tmp_path / "seen.json").read_bytes() == (tmp_path / "dark.json").read_bytes()
    assert found.encoder == "none"
    for item in found.objects[:4]:
        assert item.decided_by == item.orientation_decided_by == "priors"
        assert item.by_votes == [] and all("patches" not in one.parts for one in item.by_distance)
    assert found.objects[4].status == "failed"


def test_features_that_are_given_nevertheless_do_not_enter(world: World, tmp_path: Path) -> None:
    blind(world, world.objects.parent, tmp_path / "none.json")
    world.match(tmp_path / "given.json", snapshots=world.snapshots, **BLIND)
    assert (tmp_path / "none.json").read_bytes() == (tmp_path / "given.json").read_bytes()


def test_candidates_are_those_of_the_nearest_categories_whatever_the_shortlist(world: World, tmp_path: Path) -> None:
    found = blind(world, world.objects.parent, tmp_path / "few.json", shortlist=1, k_cat=1, least_candidates=1)
    assert {one.asset for one in found.objects[2].by_distance} == {"shelf_00"}
    assert {one.asset for one in found.objects[3].by_distance} == {"bowl_00", "bowl_01"}


def test_counts_decide_where_nothing_else_is_known(world: World, tmp_path: Path) -> None:
    found = blind(world, world.objects.parent, tmp_path / "counts.json")
    for (name, _, _), item in list(zip(SHOWN, found.objects, strict=True))[:2]:  # two doors; three drawers
        assert item.cousins[0].asset == name and item.cousins[0].parts["counts"] == 0


def test_another_judge_beside_it_needs_features(world: World, tmp_path: Path) -> None:
    for mixed in ({"model_selection": "distance"}, {"orientation_selection": "distance"}):
        with refused("E-FEATURES-MISSING"):
            blind(world, world.objects.parent, tmp_path / "mixed.json", **mixed)
    found = world.match(tmp_path / "both.json", model_selection="priors", orientation_selection="distance")
    assert found.objects[0].decided_by == "priors" and found.objects[0].cousins[0].parts["patches"] > 0


def test_a_mask_without_pixels_stops_only_those_who_look(world: World, tmp_path: Path) -> None:
    found = blind(world, world.objects.parent, tmp_path / "blind.json")
    assert (found.objects[5].id, found.objects[5].status) == ("unseen_1", "ok")
