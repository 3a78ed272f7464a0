"""Matching by pretrained networks, here tiny random ones: patch encoder dinov2, text encoder clip."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.pretrained.encoders.dinov2 import load_dinov2, read_fetched
from roomkin.stages.config.matching import MatchingConfig
from roomkin.stages.config.weights import DINOV2, FOLDER
from roomkin.stages.matching.encoders import make_encoder
from roomkin.stages.matching.ranking import make_query
from roomkin.stages.matching.text_encoders import find_nearest_categories, make_text_encoder
from tests.refusals import refused
from tests.unit.matching_data import view_of_box
from tests.unit.perception.conftest import published  # noqa: F401

CATEGORIES = ["bottom_cabinet", "coffee_table", "mug", "table", "table_lamp", "television"]


@pytest.fixture(scope="module")
def tiny_dinov2(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import torch
    from transformers import Dinov2Config, Dinov2Model

    torch.manual_seed(0)
    config = Dinov2Config(hidden_size=128, num_hidden_layers=2, num_attention_heads=2, patch_size=14, image_size=56)
    folder = tmp_path_factory.mktemp("dinov2")
    Dinov2Model(config).save_pretrained(folder)
    return folder


def dinov2(**keys: object) -> MatchingConfig:
    return MatchingConfig.model_validate({"encoder": "dinov2", "dinov2": {"height": 56, "width": 84} | keys})


def test_dinov2_encodes_patches_of_saved_weights(tiny_dinov2: Path) -> None:
    encoder = make_encoder(dinov2(path=str(tiny_dinov2)))
    views = [view_of_box(0.1), view_of_box(0.9), view_of_box(2.0)]
    patches = encoder.encode(views)
    assert all(item.features.shape == (len(item.positions), 128) for item in patches)
    assert 0 < len(patches[0].features) <= 4 * 6
    query = make_query(views[0], encoder)
    assert query is not None and query.patches.shape[1] == 128  # places have weight 0: left out
    empty = encoder.encode([replace(views[0], mask=np.zeros_like(views[0].mask))])[0]
    assert empty.features.shape == (0, 128)


def test_dinov2_checks_its_weights(tiny_dinov2: Path, tmp_path: Path) -> None:
    from safetensors.torch import load_file, save_file

    for keys, code in (
        ({"path": str(tmp_path / "nowhere")}, "E-WEIGHTS-MISSING"),
        ({"path": str(tiny_dinov2), "height": 60}, "E-PATCH-SIZE"),
    ):
        with refused(code):
            make_encoder(dinov2(**keys))
    (tmp_path / "config.json").write_text((tiny_dinov2 / "config.json").read_text())
    (tmp_path / "model.safetensors").write_bytes(b"broken")
    with refused("E-WEIGHTS-BROKEN"):
        make_encoder(dinov2(path=str(tmp_path)))
    weights = load_file(tiny_dinov2 / "model.safetensors")
    save_file({name: weights[name] for name in sorted(weights)[3:]}, tmp_path / "model.safetensors", {"format": "pt"})
    with refused("E-WEIGHTS-BROKEN"):
        make_encoder(dinov2(path=str(tmp_path)))


def test_the_fetched_dinov2_is_that_of_transformers(published: None, tmp_path: Path) -> None:  # noqa: F811
    """All its tensors but that of hidden patches, which no picture has; tokens of a square and of another grid."""
    import torch
    from safetensors.torch import save_file
    from transformers import Dinov2Config, Dinov2Model

    weights = read_fetched(FOLDER / DINOV2.name)
    save_file(
        {name: each.contiguous() for name, each in weights.items()}, tmp_path / "model.safetensors", {"format": "pt"}
    )
    size = Dinov2Config(hidden_size=384, num_attention_heads=6, patch_size=14, image_size=518)  # ViT-S/14
    size.save_pretrained(tmp_path)
    theirs, told = Dinov2Model.from_pretrained(tmp_path, output_loading_info=True)
    assert told["missing_keys"] == {"embeddings.mask_token"} and not told["unexpected_keys"]
    ours, chance = load_dinov2("", "here"), torch.Generator().manual_seed(0)
    with torch.inference_mode():
        for shape in ((224, 224), (56, 84)):
            picture = torch.randn(1, 3, *shape, generator=chance)
            expected = theirs.eval()(picture).last_hidden_state[:, 1:]
            torch.testing.assert_close(ours(picture), expected, rtol=0, atol=1e-4)
    encoder = make_encoder(MatchingConfig(encoder="dinov2"))
    near, far = (encoder.encode([view_of_box(yaw)])[0].features for yaw in (0.45, 1.2))
    query = encoder.encode([view_of_box(0.4)])[0].features
    assert np.mean(distances_to(query, near)) < 0.8 * np.mean(distances_to(query, far))


def distances_to(query: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Squared distance (P,) of each vector to the nearest of another picture."""
    nearest: np.ndarray = ((query[:, None] - other) ** 2).sum(2).min(1)
    return nearest


@pytest.fixture(scope="module")
def tiny_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import torch
    from transformers import CLIPTextConfig, CLIPTextModelWithProjection

    folder = tmp_path_factory.mktemp("clip")
    letters = "abcdefghijklmnopqrstuvwxyz"
    tokens = [*letters, *(letter + "</w>" for letter in letters), "<|startoftext|>", "<|endoftext|>"]
    (folder / "vocab.json").write_text(json.dumps({token: number for number, token in enumerate(tokens)}))
    (folder / "merges.txt").write_text("#version: 0.2\n")
    torch.manual_seed(0)
    sizes = {"hidden_size": 16, "intermediate_size": 32, "projection_dim": 8, "num_hidden_layers": 2}
    config = CLIPTextConfig(
        vocab_size=len(tokens), num_attention_heads=2, bos_token_id=52, eos_token_id=53, pad_token_id=53, **sizes
    )
    CLIPTextModelWithProjection(config).save_pretrained(folder)
    return folder


def test_clip_compares_label_and_categories(tiny_clip: Path) -> None:
    options = MatchingConfig(text_encoder="clip", clip=str(tiny_clip))
    text = make_text_encoder(options)
    result = find_nearest_categories("coffee table", CATEGORIES, 3, text)
    assert result[0] == ("coffee_table", 0.0) and 0 < result[1][1] <= 2
    forward, backward = text.distance("mug", CATEGORIES), text.distance("mug", CATEGORIES[::-1])
    np.testing.assert_allclose(forward, backward[::-1], atol=1e-6)


def test_clip_without_weights_or_tokenizer_says_what_to_do(tiny_clip: Path, tmp_path: Path) -> None:
    with refused("E-WEIGHTS-MISSING"):
        make_text_encoder(MatchingConfig(text_encoder="clip"))
    for name in ("config.json", "model.safetensors"):
        (tmp_path / name).write_bytes((tiny_clip / name).read_bytes())
    with refused("E-TOKENIZER-MISSING"):
        make_text_encoder(MatchingConfig(text_encoder="clip", clip=str(tmp_path)))
