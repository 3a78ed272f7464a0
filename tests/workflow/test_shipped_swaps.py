"""The swaps in config/swaps change what they say they change, and nothing else."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.workflow.workspace import MICRO, copy, planned, snakemake

COUSINS = "results/matching/b/room_1/cousins.json"
OBJECTS = "results/extraction/room_1/objects.json"


def objects(folder: Path) -> list[dict[str, Any]]:
    """Objects of cousins.json that have cousins."""
    return [item for item in json.loads((folder / COUSINS).read_text())["objects"] if item["cousins"]]


def picks(item: dict[str, Any]) -> list[tuple[str, float]]:
    """Its cousins with their orientations."""
    return [(cousin["asset"], cousin["orientation"]["yaw"]) for cousin in item["cousins"]]


@pytest.fixture
def folder(run: Path, tmp_path: Path) -> Path:
    return copy(run, tmp_path / "run")


def swap(folder: Path, name: str, target: str) -> set[str]:
    """Run up to `target` with a swap; the rules that ran."""
    done = snakemake(folder, target, *MICRO, f"config/swaps/{name}.yaml")
    assert done.returncode == 0, done.stdout[-3000:]
    return set(planned(done.stdout))


def test_votes_order_the_cousins(run: Path, folder: Path) -> None:
    assert swap(folder, "votes", COUSINS) == {"match"}
    for item in objects(folder):
        assert item["decided_by"] == item["orientation_decided_by"] == "votes"
        voted = [candidate["asset"] for candidate in item["by_votes"]]
        assert [cousin["asset"] for cousin in item["cousins"]][: len(voted)] == voted
        assert all(cousin["votes"] is not None for cousin in item["cousins"][: len(voted)])
    assert [picks(item) for item in objects(folder)] != [picks(item) for item in objects(run)]
    assert {item["decided_by"] for item in objects(run)} == {"geometry"}


def test_faiss_picks_the_same(run: Path, folder: Path) -> None:
    assert swap(folder, "faiss", COUSINS) == {"match"}
    assert [picks(item) for item in objects(folder)] == [picks(item) for item in objects(run)]


def test_clean_depth_is_the_renderers(run: Path, folder: Path) -> None:
    assert swap(folder, "clean_depth", OBJECTS) == {"extract"}
    exact = np.load(folder / "results/scenes/room_1/input/depth.npz")["depth"]
    clean, noisy = (np.load(place / "results/extraction/room_1/depth.npz")["depth"] for place in (folder, run))
    assert np.array_equal(clean, exact)
    seen = (exact > 0) & (noisy > 0)
    assert 0.002 < np.abs(noisy / np.where(seen, exact, 1) - 1)[seen].mean() < 0.05
