"""Training: it learns, is the same every time, and goes on where it was stopped."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file

from plugins.segmenter.network import CHANNELS, NEIGHBOURS, OUTPUTS, Segmenter, load, network_input
from plugins.segmenter.training import train as training_module
from plugins.segmenter.training.batches import boxes, draw
from plugins.segmenter.training.loss import losses, pair
from plugins.segmenter.training.options import TrainingOptions
from plugins.segmenter.training.pictures import SMALL, make_pool
from plugins.segmenter.training.solids import Solid
from plugins.segmenter.training.train import learning_rate, start_run, train, update
from tests.refusals import refused

OPTIONS = TrainingOptions(models=1, small_steps=3, large_steps=1, batch=4, save_every=2, warm_up=2)


@pytest.fixture(scope="module")
def pool() -> dict[str, list[Solid]]:
    return make_pool(1, 0)


def test_it_learns(pool: dict[str, list[Solid]]) -> None:
    options = replace(OPTIONS, small_steps=40, warm_up=5)
    run, batch = start_run("", options, 0), draw(pool, 0, SMALL, 4, 4, 0)
    before = losses(run.network(batch.inputs), batch)
    for _ in range(25):
        update(run, batch, options)
    after = losses(run.network(batch.inputs), batch)
    assert {name: bool(after[name] < 0.8 * before[name]) for name in before} == dict.fromkeys(before, True)


def test_an_interrupted_run_comes_to_the_same_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    train(tmp_path / "whole", OPTIONS, 0)
    real = training_module.update
    left = [3]

    def stop(*args: object) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        real(*args)  # type: ignore[arg-type]

    with monkeypatch.context() as patched:
        patched.setattr(training_module, "update", stop)
        with pytest.raises(KeyboardInterrupt):
            train(tmp_path / "parts", OPTIONS, 0)
    train(tmp_path / "parts", OPTIONS, 0)
    whole, parts = (load_file(tmp_path / name / "segmenter.safetensors") for name in ("whole", "parts"))
    assert all(torch.equal(whole[name], parts[name]) for name in whole)
    lines = [json.loads(line) for line in (tmp_path / "whole" / "metrics.jsonl").read_text().splitlines()]
    assert lines == []  # of ten steps each
    assert isinstance(load(tmp_path / "whole" / "segmenter.safetensors"), Segmenter)


def test_other_weights_are_refused(tmp_path: Path) -> None:
    (tmp_path / "broken.safetensors").write_bytes(b"no")
    with refused("E-WEIGHTS-UNREADABLE"):
        load(tmp_path / "broken.safetensors")


def test_the_rate_falls_to_almost_nothing() -> None:
    options = TrainingOptions()
    rates = [
        learning_rate(step, options) for step in (0, options.warm_up, options.small_steps + options.large_steps - 1)
    ]
    assert rates[0] < rates[1] and rates[2] < 0.03 * rates[1]


def test_batches_depend_on_seed_and_step_alone(pool: dict[str, list[Solid]]) -> None:
    one, same, other = (draw(pool, step, SMALL, 2, 4, 0) for step in (5, 5, 6))
    assert torch.equal(one.inputs, same.inputs) and not torch.equal(one.inputs, other.inputs)
    assert one.inputs.shape == (2, CHANNELS, 120, 160) and one.owner.shape == (2, 60, 80)


def test_outputs_are_of_any_size() -> None:
    with torch.inference_mode():
        assert Segmenter()(torch.zeros(1, CHANNELS, 118, 166)).shape == (1, OUTPUTS, 59, 83)


def test_pairs_are_so_many_rows_and_columns_apart() -> None:
    rows, columns = torch.meshgrid(torch.arange(40), torch.arange(50), indexing="ij")
    for down, beside in NEIGHBOURS:
        for values, by in ((rows, down), (columns, beside)):
            here, there = pair(values[None], down, beside)
            assert here.numel() > 0 and (there - here == by).all()


def test_a_box_is_of_what_is_seen() -> None:
    points, owner = np.zeros((4, 4, 3)), np.zeros((4, 4), int)
    owner[1:3, 1:3] = 2
    points[1, 1], points[2, 2] = [1.0, 2.0, 0.0], [3.0, 2.0, 1.0]
    points[1, 2] = points[2, 1] = [2.0, 2.0, 0.5]
    centre, radius, area = boxes(points, owner)
    assert centre[1, 1].tolist() == [2.0, 2.0, 0.5] and radius[2, 2] == pytest.approx(np.sqrt(5) / 2)
    assert area[1, 2] == 4 and area[0, 0] == 12


def test_normals_of_a_floor_point_up() -> None:
    depth = np.tile(1.5 / np.maximum((np.arange(120)[:, None] - 59.5) / 100, 1e-3), (1, 160))
    depth[depth > 10] = 0
    matrix, frame = np.array([[100.0, 0, 79.5], [0, 100.0, 59.5], [0, 0, 1]]), np.eye(4)
    frame[:3] = [[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 1.5]]
    inputs = network_input(depth, np.zeros((120, 160, 3), np.uint8), matrix, frame)
    seen = inputs[6] > 0
    assert np.abs(inputs[2][seen]).max() < 1e-5 and inputs[5][90:110, 20:140].min() > 0.99
    assert (inputs[7][~seen] == 0).all() and (inputs[8:] == -1).all()
