"""CLIP's image tower as a voice for names: what it is shown, that it is the published one, what is said without it."""

from pathlib import Path

import numpy as np
import pytest
import torch

from roomkin.stages.config import weights
from roomkin.stages.config.weights import CLIP, FOLDER
from roomkin.stages.geometry.masks import GREY
from roomkin.stages.perception.classification import clip, propose
from roomkin.stages.perception.classification.clip import SIZE, Tower, embed, load_tower, read_published, show
from roomkin.stages.perception.classification.propose import (
    WITHOUT_LOOKS,
    Observed,
    gather,
    list_silent,
    observe_looks,
    read_head,
    read_network,
    share_network,
)
from tests.unit.perception.conftest import published  # noqa: F401

RGB = np.random.default_rng(0).integers(0, 255, (60, 80, 3), np.uint8)
MASK = np.zeros((60, 80), bool)
MASK[20:50, 30:40] = True


def test_a_thing_is_shown_in_the_middle_and_what_is_around_is_blurred() -> None:
    shown = show(RGB, MASK)
    assert shown.shape == (SIZE, SIZE, 3)
    black = show(np.where(MASK[..., None], np.uint8(0), np.uint8(255)), MASK)
    wide, tall = (black[..., 0] < 30).any(axis=0).sum(), (black[..., 0] < 30).any(axis=1).sum()
    assert tall == pytest.approx(SIZE / 1.2, abs=8) and wide == pytest.approx(tall / 3, abs=8)
    middle = np.argwhere(black[..., 0] < 30).mean(axis=0)
    assert middle == pytest.approx([SIZE / 2, SIZE / 2], abs=4)
    assert np.ptp(shown[:, :10].astype(int)) < np.ptp(RGB.astype(int)) / 2


@pytest.mark.parametrize("corner", [(0, 0), (59, 79)])
def test_a_pixel_in_a_corner_is_shown_on_grey(corner: tuple[int, int]) -> None:
    mask = np.zeros((60, 80), bool)
    mask[corner] = True
    assert show(RGB, mask).shape == (SIZE, SIZE, 3)
    wide = np.zeros((60, 80), bool)
    wide[:, -2:] = True
    assert (np.abs(show(RGB, wide)[:, -1].astype(int) - GREY) < 60).all()


def test_the_tower_is_the_published_one(published: None) -> None:  # noqa: F811
    from transformers import CLIPVisionConfig, CLIPVisionModelWithProjection

    sizes = {"hidden_size": 768, "intermediate_size": 3072, "num_hidden_layers": 12, "num_attention_heads": 12}
    config = CLIPVisionConfig(**sizes, patch_size=16, image_size=224, projection_dim=512, hidden_act="quick_gelu")
    theirs = CLIPVisionModelWithProjection(config).eval()
    weights = read_published(FOLDER / CLIP.name)
    held = theirs.state_dict()
    theirs.load_state_dict(
        {name: weights[name].reshape(value.shape) for name, value in held.items() if name in weights}
    )
    assert not {name for name in held if "position_ids" not in name} - weights.keys()
    picture, tower = torch.randn(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(0)), load_tower()
    assert tower is not None
    with torch.inference_mode():
        assert torch.allclose(tower(picture), theirs(picture).image_embeds, atol=1e-4)
    found = embed(tower, np.stack([show(RGB, MASK)] * 2))
    assert np.linalg.norm(found, axis=1) == pytest.approx(1) and found[0] == pytest.approx(found[1], abs=1e-5)


def test_nothing_to_embed_gives_nothing() -> None:
    assert embed(Tower(), np.zeros((0, SIZE, SIZE, 3), np.uint8)).shape == (0, 512)


def test_the_head_names_what_the_shape_network_names() -> None:
    assert read_head()[1] == read_network()[1]
    share = share_network(read_head(), read_network()[1], torch.eye(512)[0])
    assert share.sum() == pytest.approx(1) and np.ptp(share) > 0


def test_looks_are_a_vote() -> None:
    names = read_network()[1]
    head = read_head()[0].weight.detach().numpy()[names.index("sofa")].astype(float)
    said = gather(Observed(None, None, head / np.linalg.norm(head)), None, names)
    assert names[int(said[3].argmax())] == "sofa" and np.ptp(said[:3]) == pytest.approx(0)


def test_weights_that_lacked_are_asked_for_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_tower(tmp_path) is None
    (tmp_path / CLIP.name).touch()
    monkeypatch.setattr(weights, "is_there", lambda *_: True)
    monkeypatch.setattr(clip, "read_published", lambda path: path)
    monkeypatch.setattr(clip, "fill", lambda tower, path: path.name)
    assert load_tower(tmp_path) == CLIP.name


def test_without_the_weights_a_line_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert load_tower(tmp_path) is None
    monkeypatch.setattr(propose, "load_tower", lambda: None)
    assert observe_looks(RGB, MASK).looks is None and WITHOUT_LOOKS in list_silent()
