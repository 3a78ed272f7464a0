"""The network, its weights, and the encoder."""

from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import torch
from torch import nn
from torch.nn import functional

from roomkin.plugins.efficientnet.encoders.efficientnet import Encoder
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.config.model import load, with_defaults
from roomkin.stages.matching.encoders import make_encoder
from roomkin.stages.perception.classification import efficientnet as network
from tests.refusals import refused
from tests.unit.matching_data import before_noise, view_of_box

OPTIONS = MatchingConfig(encoder="roomkin.plugins.efficientnet.encoders.efficientnet")


@pytest.fixture(scope="module")
def encoder() -> Encoder:
    made = make_encoder(OPTIONS)
    assert isinstance(made, Encoder)
    return made


def published() -> dict[str, torch.Tensor]:
    """Random weights by the published names, for all blocks."""
    chance = torch.Generator().manual_seed(0)
    names = {"stem": "_bn0", "expand": "_bn0", "depthwise": "_bn1", "project": "_bn2"}
    state = {}
    for key, value in network.EfficientNet(None).state_dict().items():
        path, _, part = key.removesuffix(".weight").removesuffix(".bias").rpartition(".")
        place = f"_{path}." if path else ""
        if key.endswith(".weight"):
            convolution = "_conv_stem" if part == "stem" else f"_{part}_conv"
            state[f"{place}{convolution}.weight"] = torch.randn(value.shape, generator=chance)
        else:
            for name in ("weight", "bias", "running_mean", "running_var"):
                state[f"{place}{names[part]}.{name}"] = torch.rand(value.shape, generator=chance) + 0.5
    return state


def test_folded_weights_do_what_convolution_and_normalisation_do() -> None:
    state = published()
    folded = network.fold(state)
    assert set(folded) == set(network.EfficientNet(None).state_dict())
    x = torch.randn(1, 32, 8, 8, generator=torch.Generator().manual_seed(1))
    block = network.InvertedBlock(32, 16, 3, 1, 1)
    block.load_state_dict(
        {name.removeprefix("blocks.0."): value for name, value in folded.items() if "blocks.0." in name}
    )
    y = x
    for part, norm, groups, active in (("depthwise", "_bn1", 32, True), ("project", "_bn2", 1, False)):
        weight = state[f"_blocks.0._{part}_conv.weight"]
        y = functional.conv2d(y, weight, padding=weight.shape[-1] // 2, groups=groups)
        values = [state[f"_blocks.0.{norm}.{name}"] for name in ("running_mean", "running_var", "weight", "bias")]
        y = functional.batch_norm(y, *values, eps=network.EPSILON)
        y = functional.relu6(y) if active else y
    torch.testing.assert_close(block(x), y, rtol=1e-3, atol=1e-3)


def test_a_stride_of_two_sees_one_more_pixel_right_and_below() -> None:
    convolution = network.Convolution(1, 1, 3, 2)
    nn.init.ones_(convolution.weight)
    nn.init.zeros_(convolution.bias)  # type: ignore[arg-type]
    x = torch.zeros(1, 1, 4, 4)
    x[..., 0, 0] = 1
    assert convolution(x)[0, 0].tolist() == [[1, 0], [0, 0]]
    x = torch.zeros(1, 1, 4, 4)
    x[..., 2, 2] = 1
    assert convolution(x)[0, 0].tolist() == [[1, 1], [1, 1]]


def test_features_of_stride_16_are_of_weights_in_fp16() -> None:
    for weight in network.load().state_dict().values():
        assert torch.equal(weight, weight.half().float())


def test_patches_are_unit_vectors_of_the_foreground(encoder: Encoder) -> None:
    view = view_of_box(0.4)
    empty = replace(view, mask=np.zeros_like(view.mask))
    patches, nothing = encoder.encode([view, empty])
    assert patches.features.shape[1] == 112 and len(patches.features) == len(patches.positions) > 20
    np.testing.assert_allclose(np.linalg.norm(patches.features, axis=1), 1, atol=1e-5)
    assert nothing.features.shape == (0, 112)
    assert encoder.weights(depth=True)[-3:].tolist() == [1, 0.5, 0.5]


def test_background_does_not_matter(encoder: Encoder) -> None:
    view = view_of_box(0.4)
    both = (view, before_noise(view))
    np.testing.assert_array_equal(*(encoder.encode([each])[0].features for each in both))


def test_the_same_box_turned_a_little_is_nearer_than_turned_a_lot(encoder: Encoder) -> None:
    def rows(yaw: float) -> np.ndarray:
        return encoder.encode([view_of_box(yaw)])[0].features

    near, far = (((rows(0.4)[:, None] - rows(yaw)) ** 2).sum(2).min(1).mean() for yaw in (0.45, 1.2))
    assert near < 0.8 * far


def absent(name: str) -> NoReturn:
    """A package that is not installed."""
    raise PackageNotFoundError(name)


def test_the_classifier_says_what_the_published_code_says() -> None:
    """Logits of efficientnet-lite-pytorch 0.1.0 for a picture of two ramps."""
    weights = network.published_file()
    y, x = np.mgrid[:224, :224]
    picture = np.stack([x, y, (x + y) // 2], axis=-1).astype(np.uint8)
    with torch.inference_mode():
        scores = network.fill(network.Classifier(), weights)(network.to_input(picture[None]))[0]
    assert scores.shape == (1000,)
    expected = torch.tensor([-0.1377, 0.1868, 1.1314, 3.9414, 3.8399])
    torch.testing.assert_close(scores[[0, 1, 2, 818, 782]], expected, rtol=0, atol=1e-3)


def test_weights_that_are_not_installed_or_others_are_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with monkeypatch.context() as without:
        without.setattr(network, "distribution", absent)
        with refused("E-WEIGHTS-MISSING"):
            network.load()
    torch.save(published(), file := tmp_path / "lite0.pth")
    monkeypatch.setattr(network, "published_file", lambda: file)
    with refused("E-WEIGHTS-OTHER", "lite0.pth"):
        network.load()


@pytest.mark.parametrize("kwargs", [{"positon": 1.0}, {"position": -1.0}])
def test_options_that_cannot_be_are_refused(kwargs: dict[str, float]) -> None:
    with refused("E-PLUGIN-OPTION"):
        make_encoder(OPTIONS.model_copy(update={"kwargs": {"efficientnet": kwargs}}))


def test_the_config_finds_it_by_its_name() -> None:
    config = load(with_defaults({"matching": {"encoder": "efficientnet"}}))
    assert isinstance(make_encoder(config.matching), Encoder)
