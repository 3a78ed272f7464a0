"""The swaps in config/swaps change what they say they change, and nothing else."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from roomkin.stages.config.model import Config, read_files
from roomkin.stages.config.reads import options_of
from roomkin.stages.extraction import extract
from roomkin.stages.matching import match
from tests.workflow.workspace import MICRO, ROOT, copy, dry_run, planned

COUSINS = "results/matching/default/room_1/cousins.json"
OBJECTS = "results/extraction/room_1/objects.json"


@pytest.mark.parametrize(
    ("name", "target", "rules"),
    [("votes", COUSINS, {"match"}), ("faiss", COUSINS, {"match"}), ("clean_depth", OBJECTS, {"extract"})],
)
def test_a_swap_reruns_its_own_rule(run: Path, tmp_path: Path, name: str, target: str, rules: set[str]) -> None:
    folder = copy(run, tmp_path / "run")
    assert set(planned(dry_run(folder, target, *MICRO, f"config/swaps/{name}.yaml").stdout)) == rules


def config_with(name: str) -> Config:
    """The config of the micro run with a swap."""
    return read_files([ROOT / "config.yaml", ROOT / MICRO[1], ROOT / f"config/swaps/{name}.yaml"])


def match_again(run: Path, out: Path, name: str) -> list[dict[str, Any]]:
    """Objects with cousins, matched with a swap."""
    results = run / "results"
    match.run(
        objects=run / OBJECTS,
        image=results / "scenes/room_1/input/rgb.png",
        library=results / "assets/library/library.json",
        features=tuple(sorted(results.glob("matching/features/*/shard_*.npy"))),
        snapshots=tuple(sorted(results.glob("assets/snapshots/shard_*.h5"))),
        options=json.dumps(options_of(config_with(name), "matching", "match", {"variant": "default"})),
        out=out,
    )
    return objects(out)


def objects(path: Path) -> list[dict[str, Any]]:
    """Objects of cousins.json that have cousins."""
    return [item for item in json.loads(path.read_text())["objects"] if item["cousins"]]


def picks(item: dict[str, Any]) -> list[tuple[str, float]]:
    """Its cousins with their orientations."""
    return [(cousin["asset"], cousin["orientation"]["yaw"]) for cousin in item["cousins"]]


def test_votes_order_the_cousins(run: Path, tmp_path: Path) -> None:
    found, usual = match_again(run, tmp_path / "cousins.json", "votes"), objects(run / COUSINS)
    for item in found:
        assert item["decided_by"] == item["orientation_decided_by"] == "votes"
        voted = [candidate["asset"] for candidate in item["by_votes"]]
        assert [cousin["asset"] for cousin in item["cousins"]][: len(voted)] == voted
        assert all(cousin["votes"] is not None for cousin in item["cousins"][: len(voted)])
    assert list(map(picks, found)) != list(map(picks, usual))
    assert {item["decided_by"] for item in usual} == {"geometry"}


def test_faiss_picks_the_same(run: Path, tmp_path: Path) -> None:
    found = match_again(run, tmp_path / "cousins.json", "faiss")
    assert list(map(picks, found)) == list(map(picks, objects(run / COUSINS)))


def test_clean_depth_is_the_renderers(run: Path, tmp_path: Path) -> None:
    given = run / "results/scenes/room_1/input"
    options = options_of(config_with("clean_depth"), "extraction", "extract", {"scene": "room_1"})
    extract.run(input=given, scene="room_1", out=tmp_path / "objects.json", options=json.dumps(options))
    exact = np.load(given / "depth.npz")["depth"]
    clean, noisy = (
        np.load(path.with_name("depth.npz"))["depth"] for path in (tmp_path / "objects.json", run / OBJECTS)
    )
    assert np.array_equal(clean, exact)
    seen = (exact > 0) & (noisy > 0)
    assert 0.002 < np.abs(noisy / np.where(seen, exact, 1) - 1)[seen].mean() < 0.05
