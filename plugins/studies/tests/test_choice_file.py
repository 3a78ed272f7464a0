"""`choice.json`: what it must hold."""

import json
from pathlib import Path
from typing import Any

import pytest

from plugins.studies.choice import Choice
from stages.contracts.errors import InputError
from stages.contracts.files import read_json
from tests.unit.demo_assets import FRONT

MODEL = {"size": [0.5, 0.6, 1.0], "category": "cabinet", "joint": "door_joint", **FRONT}
MODEL.pop("panel_height")
CHOICE: dict[str, Any] = {
    "version": 1, "task": "door", "rule": "chance", "seed": 0, "like": None, "box": None, "usable": 20, "families": 12,
    "models": [{"asset": name, "family": name, **MODEL} for name in ("cabinet_0", "cabinet_1")], "within_1": 0.75,
    "within_2": 1.0, "greedy_within_1": 0.8, "most_within_1": 0.85, "forecast": 0.7, "alone": ["cabinet_9"],
}  # fmt: skip


def read(path: Path, content: dict[str, Any]) -> Choice:
    path.write_text(json.dumps(content))
    return read_json(Choice, path)


def test_a_whole_one_is_read(tmp_path: Path) -> None:
    assert [model.asset for model in read(tmp_path / "choice.json", CHOICE).models] == ["cabinet_0", "cabinet_1"]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("models", [], "models"), ("models", [{**CHOICE["models"][0], "size": [1.0, 1.0]}], "models.0.size"),
        ("models", [CHOICE["models"][0]] * 2, "families"), ("seed", -1, "seed"), ("within_1", 0.9, "most_within_1"),
        ("within_2", 0.7, "within_2"), ("within_2", 1.1, "within_2"), ("forecast", 70.0, "forecast"),
        ("alone", ["a", "a"], "alone"), ("box", [0.0, 1.0, 1.0], "box"), ("version", 2, "is version 2"),
    ],
)  # fmt: skip
def test_a_broken_one_is_refused(tmp_path: Path, key: str, value: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read(tmp_path / "choice.json", CHOICE | {key: value})
