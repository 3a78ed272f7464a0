"""Names of files reach the config as they were typed, through make, a shell and Snakemake's YAML."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    "name",
    [
        "000048",
        "2024_05_01",
        "frame #3.png",
        "kitchen: first.png",
        "Küche 1.png",
        'it\'s `x` $HOME "q".png',
        "a,b(1).png",
    ],
)
def test_a_name_is_what_was_typed(name: str) -> None:
    from snakemake.cli import parse_config

    planned = subprocess.run(
        ["make", "-n", "picture", f"RGB={name}", f"DEPTH={name}", "INTRINSICS=k.json"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    (line,) = (line for line in planned.splitlines() if " photo " in line)
    words = subprocess.run(
        ["bash", "-c", f"printf '%s\\0' {line.partition('--config')[2]}"], capture_output=True, text=True, check=True
    ).stdout
    config = parse_config(words.rstrip("\0").split("\0"))
    assert config == {"image": name, "depth": name, "camera": "k.json"}
