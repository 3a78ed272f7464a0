"""A run whose weights of DINOv2 are not here goes on with the other variants, and says so."""

from pathlib import Path
from typing import Any

import pytest

from roomkin.stages.config import weights
from roomkin.stages.config.model import load, with_defaults
from roomkin.stages.config.weights import DINOV2
from tests.packages import needs
from tests.refusals import refused

PAPER, OURS = {"encoder": "dinov2"}, {"encoder": "hog"}


def asked(**variants: dict[str, Any]) -> dict[str, Any]:
    """A merged config with these variants, the first of them placed otherwise, and a protocol of it alone."""
    first = next(iter(variants))
    protocols = {"recoloured": {"seeds": [0], "variants": [first]}, "noise": {"seeds": [1], "variants": [*variants]}}
    experiment = {"variants": variants, "placements": {first: {"trim": 0}}, "protocols": protocols}
    return with_defaults({"matching": {}, "experiment": experiment | {"targets": {}, "training_sets": []}})


def put(monkeypatch: pytest.MonkeyPatch, folder: Path, there: bool) -> None:
    """Weights, or none."""
    monkeypatch.setattr(weights, "FOLDER", folder)
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: there)
    if there:
        (folder / DINOV2.name).touch()


@needs("pretrained", "scenes")
def test_its_variants_are_left_out_with_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, tmp_path, there=False)
    given = asked(paper=PAPER, ours=OURS)
    given["experiment"] |= {"policy_variant": "paper", "targets": {"door": None}}
    for config in (load(given),):
        experiment = config.experiment
        assert [name for name in experiment.variants if name in ("paper", "ours")] == ["ours"]
        assert "paper" not in experiment.placements and experiment.policy_variant in experiment.variants
        assert experiment.protocols.keys() == {"noise"} and "paper" not in (
            experiment.protocols["noise"].variants or []
        )
        assert weights.tell_left_out(given, config).endswith("(make weights): without variant paper")


@needs("pretrained", "scenes")
def test_with_the_weights_nothing_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, tmp_path, there=True)
    config = load(asked(paper=PAPER, ours=OURS))
    assert {"paper", "ours"} <= config.experiment.variants.keys() and "paper" in config.experiment.placements
    assert weights.tell_left_out(asked(paper=PAPER, ours=OURS), config) == ""


@needs("pretrained", "scenes")
def test_where_nothing_else_is_left_it_is_a_mistake(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(monkeypatch, tmp_path, there=False)
    with refused("E-CONFIG-FILE", "matching.dinov2.path: no vit_s_focus.onnx", "make weights"):
        load(with_defaults({"matching": PAPER}))
