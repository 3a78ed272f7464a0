"""Pairs of pictures with their correspondences, the losses, training that can be repeated and resumed."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import torch

from plugins.patchnet.network import GRID, SIZE, PatchNet, seen_categories
from plugins.patchnet.training import train as module
from plugins.patchnet.training.batches import Pairs, draw, mirror
from plugins.patchnet.training.loss import find_same_looks, losses
from plugins.patchnet.training.options import TrainingOptions
from plugins.patchnet.training.pairs import NONE, foreground_of, hide_part, matches
from stages.geometry.cameras import back_project, look_at
from stages.geometry.frames import inverse, rigid, yaw_matrix
from tests.refusals import refused
from tests.unit.matching_data import view_of_box

PATCHES = GRID * GRID
train = module.train


def box_from_camera(yaw: float) -> np.ndarray:
    """(4, 4) from the camera of `view_of_box` to the box."""
    pose = look_at(3 * np.array([np.cos(0.3), 0, np.sin(0.3)]), [0, 0, 0])
    return rigid(yaw_matrix(-yaw), np.zeros(3)) @ pose


def test_a_patch_matches_the_patch_that_shows_the_same_point() -> None:
    one, other = view_of_box(0.3), view_of_box(0.45)
    itself = matches(one, box_from_camera(0.3), one, inverse(box_from_camera(0.3)))
    kept = itself != NONE
    assert (itself[kept] == np.arange(PATCHES)[kept]).all() and kept.sum() > 0.9 * foreground_of(one).sum()
    across = matches(one, box_from_camera(0.3), other, inverse(box_from_camera(0.45)))
    kept = across != NONE
    assert 0.6 * foreground_of(one).sum() < kept.sum() and (across[kept] != np.arange(PATCHES)[kept]).mean() > 0.3
    turned = matches(one, box_from_camera(0.3), view_of_box(0.3 + np.pi), inverse(box_from_camera(0.3 + np.pi)))
    assert (turned != NONE).mean() < 0.5 * kept.mean()  # the sides that are seen now were not: the top alone is left


def test_at_least_half_of_a_model_stays_to_be_seen() -> None:
    view, rng = view_of_box(0.3), np.random.default_rng(0)
    shares = [hide_part(view, rng).mask.sum() / view.mask.sum() for _ in range(40)]
    assert min(shares) >= 0.5 and np.mean(np.array(shares) < 0.99) > 0.6


def test_mirrored_pairs_match_as_before() -> None:
    there = torch.arange(PATCHES)[None].clone()
    there[0, :5] = NONE
    back = mirror(there)
    assert (back[0, GRID - 5 : GRID] == NONE).all() and (mirror(back) == there).all()
    assert back[0, GRID] == GRID  # what was in the last column matched the last column, which is now the first


def test_losses_fall_to_nothing_when_every_patch_is_found() -> None:
    rows = torch.eye(2 * PATCHES).view(2, PATCHES, -1)
    owners = torch.arange(2).repeat_interleave(PATCHES)
    targets = torch.arange(PATCHES).repeat(2)
    visible, alike = torch.ones(2, PATCHES, dtype=torch.bool), torch.eye(2, dtype=torch.bool)
    right = losses(rows.flatten(0, 1), rows, owners, targets, visible, alike, 0.02)
    swapped = losses(rows.flip(0).flatten(0, 1), rows, owners, targets, visible, alike, 0.02)
    assert right[0] < 1e-6 and right[1] < 1e-6 and right[2] == 1
    assert swapped[0] > 5 and swapped[1] > 5 and swapped[2] == 0
    same = losses(rows.flip(0).flatten(0, 1), rows, owners, targets, visible, torch.ones(2, 2, dtype=torch.bool), 0.02)
    assert same[1] < 1e-6  # a snapshot that looks the same is not wrong


def test_snapshots_look_the_same_as_the_symmetry_says() -> None:
    models = torch.tensor([0, 0, 0, 1, 1])
    yaws = torch.tensor([0.0, np.pi, 1.0, 0.0, 2.0])
    periods = torch.tensor([np.pi] * 3 + [0.0] * 2)
    alike = find_same_looks(models, yaws, periods)
    assert alike.diagonal().all() and (alike == alike.T).all()
    assert alike[0, 1] and alike[3, 4] and not alike[0, 2] and not alike[0, 3]


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four models of coloured noise, three views each, whose two pictures are equal."""
    path = tmp_path_factory.mktemp("pairs") / "pairs.h5"
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (12, 1, GRID, GRID, 4), dtype=np.uint8).repeat(2, axis=1)
    crops = noise.repeat(SIZE // GRID, axis=2).repeat(SIZE // GRID, axis=3)
    crops[..., 3] = 255
    with h5py.File(path, "w") as file:
        file["crops"], file["yaws"], file["periods"] = crops, np.arange(12, dtype="f4"), np.full(4, 2 * np.pi, "f4")
        file["matches"] = np.tile(np.arange(PATCHES, dtype=np.int16), (12, 1))
        file["models"] = [f"noise_{k}" for k in range(4)]
        file.attrs["about"] = "noise"
    return path


def options(steps: int) -> TrainingOptions:
    """In fp32: many processors only imitate bf16, ten times slower."""
    return TrainingOptions(steps=steps, batch_models=2, batch_views=2, warm_up=2, save_every=4, precision="fp32")


def test_training_learns_and_goes_on_where_it_was(pairs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LOG_EVERY", 1)
    train(pairs, tmp_path / "whole", options(8), 3)
    train(pairs, tmp_path / "parts", options(5), 3)  # its last state is that of step 4
    train(pairs, tmp_path / "parts", options(8), 3)
    whole, parts = ((tmp_path / name / "patchnet.safetensors").read_bytes() for name in ("whole", "parts"))
    assert whole == parts and len(whole) < 8e6
    assert seen_categories(tmp_path / "whole/patchnet.safetensors") == ["noise"]
    match = [json.loads(line)["match"] for line in (tmp_path / "whole/metrics.jsonl").read_text().splitlines()]
    assert len(match) == 8 and min(match[-4:]) < 0.9 * match[0]
    train(pairs, tmp_path / "parts", options(1), 4)  # another run does not go on from it
    assert (tmp_path / "parts/patchnet.safetensors").read_bytes() != whole


def test_a_run_on_other_pairs_starts_anew(pairs: Path, tmp_path: Path) -> None:
    others = tmp_path / "others.h5"
    shutil.copy(pairs, others)
    with h5py.File(others, "r+") as file:
        file.attrs["about"] = "other noise"
        file["crops"][..., :3] = 255 - file["crops"][..., :3]
    train(pairs, tmp_path / "again", options(5), 3)
    for name in ("again", "fresh"):
        train(others, tmp_path / name, options(2), 3)
    again, fresh = ((tmp_path / name / "patchnet.safetensors").read_bytes() for name in ("again", "fresh"))
    assert again == fresh


def test_the_largest_seed_trains_in_the_precision_of_the_shipped_weights(pairs: Path, tmp_path: Path) -> None:
    train(pairs, tmp_path, replace(options(1), precision="bf16"), 2**53 - 1)
    assert (tmp_path / "patchnet.safetensors").is_file()


def test_a_batch_depends_on_seed_and_step_alone(pairs: Path) -> None:
    chosen = TrainingOptions(batch_models=3, batch_views=2)
    one, again, next_one = (draw(Pairs(pairs), step, 0, chosen) for step in (5, 5, 6))
    other_seed = draw(Pairs(pairs), 5, 2**53 - 1, chosen)
    assert not torch.equal(one.crops, other_seed.crops)
    assert torch.equal(one.crops, again.crops) and not torch.equal(one.crops, next_one.crops)
    assert one.crops.shape == (2, 6, 4, SIZE, SIZE) and one.crops.abs().max() <= 1.001
    assert one.visible.all() and one.models.tolist() == [0, 0, 1, 1, 2, 2]


def test_patches_are_unit_vectors() -> None:
    maps = PatchNet()(torch.randn(2, 4, SIZE, SIZE))
    assert maps.shape == (2, 128, GRID, GRID)
    torch.testing.assert_close(maps.norm(dim=1), torch.ones(2, GRID, GRID))


def test_missing_pairs_are_named(tmp_path: Path) -> None:
    with refused("E-FILE-MISSING", "pairs.h5"):
        train(tmp_path / "pairs.h5", tmp_path / "out", TrainingOptions(), 0)


def test_back_projection_is_what_the_matches_rest_on() -> None:
    view = view_of_box(0.3)
    points = back_project(view.depth, view.intrinsics)[view.mask]  # type: ignore[arg-type]
    on_box = points @ box_from_camera(0.3)[:3, :3].T + box_from_camera(0.3)[:3, 3]
    assert np.abs(np.abs(on_box) / [0.3, 0.5, 0.4]).max() < 1.001
