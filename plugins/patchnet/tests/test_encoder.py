"""The encoder, and its file of weights."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from safetensors.torch import save_file

from plugins.patchnet import network
from plugins.patchnet.encoders.patchnet import Encoder
from stages.config.matching import MatchingConfig
from stages.config.model import load, with_defaults
from stages.matching.encoders import make_encoder, settings_digest
from stages.matching.ranking import make_query
from tests.refusals import refused
from tests.unit.matching_data import before_noise, view_of_box

OPTIONS = MatchingConfig(encoder="plugins.patchnet.encoders.patchnet")


@pytest.fixture(scope="module")
def encoder() -> Encoder:
    made = make_encoder(OPTIONS)
    assert isinstance(made, Encoder)
    return made


def test_the_network_stands_beside_the_columns_of_hog_on_the_same_patches(encoder: Encoder) -> None:
    view = view_of_box(0.4)
    empty = replace(view, mask=np.zeros_like(view.mask))
    patches, nothing, other = encoder.encode([view, empty, view_of_box(0.9)])
    hog = make_encoder(MatchingConfig()).encode([view])[0]
    np.testing.assert_allclose(np.linalg.norm(patches.features[:, : network.COLUMNS], axis=1), 1, atol=1e-5)
    np.testing.assert_array_equal(patches.features[:, network.COLUMNS :], hog.features)
    np.testing.assert_array_equal(patches.positions, hog.positions)
    assert nothing.features.shape == (0, 398) and len(other.features)


def test_background_does_not_matter(encoder: Encoder) -> None:
    view = view_of_box(0.4)
    both = (view, before_noise(view))
    np.testing.assert_array_equal(*(encoder.encode([each])[0].features for each in both))


def test_the_same_box_turned_a_little_is_nearer_than_turned_a_lot(encoder: Encoder) -> None:
    def rows(yaw: float) -> np.ndarray:
        return encoder.encode([view_of_box(yaw)])[0].features[:, : network.COLUMNS]

    near, far = (((rows(0.4)[:, None] - rows(yaw)) ** 2).sum(2).min(1).mean() for yaw in (0.45, 1.2))
    assert near < 0.7 * far


def test_weights_are_laid_on_when_patches_are_compared(encoder: Encoder) -> None:
    changed = OPTIONS.model_copy(update={"own": {"patchnet": {"hog": 0.0}}})
    assert settings_digest(changed, make_encoder(changed)) == settings_digest(OPTIONS, encoder)
    view = view_of_box(0.4)
    lengths = [
        query.patches.shape[1]
        for given in (OPTIONS, changed)
        for each in (view, replace(view, depth=None))
        if (query := make_query(each, make_encoder(given)))
    ]
    assert lengths == [400, 373, 157, 130]


def test_weights_that_are_not_those_of_the_network_are_refused(tmp_path: Path) -> None:
    whole = network.WEIGHTS.read_bytes()
    assert len(whole) < 8e6
    for name, content in (("none", b""), ("half", whole[: len(whole) // 2]), ("text", b"no weights at all")):
        (tmp_path / name).write_bytes(content)
        with refused("E-WEIGHTS-UNREADABLE"):
            network.load(tmp_path / name)
    with refused("E-WEIGHTS-UNREADABLE"):
        network.load(tmp_path / "missing")
    save_file({"head.bias": torch.zeros(3)}, tmp_path / "other")
    with refused("E-WEIGHTS-OTHER"):
        network.load(tmp_path / "other")


@pytest.mark.parametrize("own", [{"hogg": 1.0}, {"hog": -1.0}])
def test_weights_of_the_parts_that_cannot_be_are_refused(own: dict[str, float]) -> None:
    with refused("E-PATCHNET-OPTION"):
        make_encoder(OPTIONS.model_copy(update={"own": {"patchnet": own}}))


def test_the_shipped_swap_finds_it_by_its_name() -> None:
    swap = yaml.safe_load(Path("config/swaps/patchnet.yaml").read_text())
    config = load(with_defaults(swap))
    assert config.matching_of("b").encoder == OPTIONS.encoder
