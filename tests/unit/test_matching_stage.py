"""Matching end to end on a ray-traced library: features, match, distances, and what happens to bad input."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.config.packages import load_command
from roomkin.stages.contracts import LeftOut, write_json
from roomkin.stages.geometry.frames import angle_difference
from roomkin.stages.matching.match import run as match
from roomkin.stages.plugins import list_available
from tests.packages import needs
from tests.refusals import refused
from tests.unit.matching_data import SHOWN, World


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("matching"))


@pytest.mark.parametrize("decides", ["distance", "votes"])
def test_models_and_orientations_are_found(world: World, tmp_path: Path, decides: str) -> None:
    result = world.match(tmp_path / "cousins.json", model_selection=decides, orientation_selection=decides, k_cousins=3)
    for (name, yaw, _), entry in list(zip(SHOWN, result.objects, strict=True))[:4]:
        assert entry.status == "ok" and entry.decided_by == entry.orientation_decided_by == decides
        best = entry.cousins[0]
        assert best.asset == name, f"{entry.id}: {[cousin.asset for cousin in entry.cousins]}"
        if best.category != "bowl":  # their sides look alike
            assert angle_difference(best.orientation.yaw, yaw) <= 0.42, entry.id  # steps of 0.39
        assert [cousin.rank for cousin in entry.cousins] == list(range(1, len(entry.cousins) + 1))
        assert entry.by_distance == sorted(entry.by_distance, key=lambda candidate: candidate.distance)
        assert {candidate.asset for candidate in entry.by_votes} <= {candidate.asset for candidate in entry.by_distance}
        assert len(best.orientations) == 4 and best.orientations[0] == best.orientation
    assert all(cousin.category == "cabinet" for cousin in result.objects[0].cousins)


def test_models_are_compared_by_representatives_if_asked(world: World, tmp_path: Path) -> None:
    """The paper's way; distances are then those to the last view, which no orientation has."""
    result = world.match(tmp_path / "cousins.json", views=0, least_candidates=1)
    first = result.objects[0]
    assert {candidate.asset for candidate in first.by_distance} == {"cabinet_00", "cabinet_02", "cabinet_03"}
    assert all(cousin.distance != cousin.orientation.distance for cousin in first.cousins)


def test_models_can_be_left_out_of_the_library(world: World, tmp_path: Path) -> None:
    first = world.match(tmp_path / "all.json").objects[0].cousins[0].asset
    write_json(tmp_path / "without.json", LeftOut(assets=[first]))
    found = world.match(tmp_path / "cousins.json", without=[tmp_path / "without.json"]).objects[0].cousins
    assert found and first not in [cousin.asset for cousin in found]


def test_one_bad_object_does_not_stop_the_scene(world: World, tmp_path: Path) -> None:
    result = world.match(tmp_path / "cousins.json")
    lost, unseen = result.objects[4:]
    assert (lost.status, lost.reason) == ("failed", "extraction: no points")
    assert unseen.status == "failed" and "mask 99 has no pixel" in unseen.reason


@needs("pictures")
def test_objects_are_drawn_beside_their_cousins(world: World, tmp_path: Path) -> None:
    world.match(tmp_path / "cousins.json")
    files = {"cousins": tmp_path / "cousins.json", "objects": world.objects, "image": world.objects.parent / "rgb.png"}
    load_command("pictures", "cousins")(**files, snapshots=world.snapshots, out=tmp_path / "cousins.png")
    assert (tmp_path / "cousins.png").stat().st_size > 10_000


def test_backends_pick_the_same_and_a_second_run_writes_the_same_bytes(world: World, tmp_path: Path) -> None:
    others = sorted(list_available("searches").keys() - {"torch"})  # of packages
    first, second, *found = (
        world.match(tmp_path / f"{name}.json", search=search)
        for name, search in zip("abc", ["torch", "torch", *others], strict=False)
    )
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    for ours, theirs in [pair for other in found for pair in zip(first.objects, other.objects, strict=True)]:
        for picks in ("by_votes", "by_distance", "cousins"):
            a, b = getattr(ours, picks), getattr(theirs, picks)
            assert [(pick.asset, pick.votes) for pick in a] == [(pick.asset, pick.votes) for pick in b]
            assert [pick.distance for pick in a] == pytest.approx([pick.distance for pick in b], abs=2e-4)
        yaws = [[cousin.orientation.yaw for cousin in entry.cousins] for entry in (ours, theirs)]
        assert yaws[0] == yaws[1]
    assert second.objects == first.objects


def test_other_features_are_told_by_the_digest_of_what_went_in(world: World, tmp_path: Path) -> None:
    first, again = (world.match(tmp_path / f"{name}.json").made for name in ("first", "again"))
    wholes_file = world.features[0].with_suffix(".npz")
    kept = wholes_file.read_bytes()
    with np.load(wholes_file) as stored:
        wholes = {name: stored[name] for name in stored.files}
    np.savez(wholes_file, **(wholes | {"wholes": wholes["wholes"] * 0.5}))
    try:
        other = world.match(tmp_path / "other.json").made
    finally:
        wholes_file.write_bytes(kept)
    assert first and other and first == again and first.inputs != other.inputs


def test_search_without_depth(world: World, tmp_path: Path) -> None:
    depth = world.objects.parent / "depth.npz"
    kept = depth.read_bytes()
    depth.unlink()
    try:
        result = world.match(tmp_path / "cousins.json")
    finally:
        depth.write_bytes(kept)
    assert [entry.cousins[0].asset for entry in result.objects[:2]] == ["cabinet_00", "cabinet_01"]


def test_unusable_input_is_refused_in_one_line_and_leaves_nothing(world: World, tmp_path: Path) -> None:
    out = tmp_path / "cousins.json"
    with refused("E-FEATURES-OTHER"):
        world.match(out, hog={"grid": 12})
    with refused("E-FEATURES-MISSING"):
        match(
            objects=world.objects,
            image=world.objects.parent / "rgb.png",
            library=world.library,
            features=world.features[:1],
            out=out,
        )
    assert not out.exists()
