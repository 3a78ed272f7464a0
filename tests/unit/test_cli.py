"""Every command refuses the seeds that config would before it reads or writes anything; progress is told."""

import importlib
import inspect
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from roomkin.stages import cli
from roomkin.stages.contracts.section import Seed
from tests.refusals import refused


def seeded() -> list[Callable[..., None]]:
    """The commands with a seed among their flags."""
    root = Path(cli.__file__).parents[2]
    paths = [path for home in ("stages", "plugins") for path in (root / "roomkin" / home).glob("*/*.py")]
    files = [path for path in paths if "\ndef run(" in path.read_text("utf-8")]
    commands = (path for path in files if re.search(r"\bseed: int", path.read_text("utf-8")))
    runs = [importlib.import_module(".".join(path.relative_to(root).with_suffix("").parts)).run for path in commands]
    return [run for run in runs if any(name.endswith("seed") for name in inspect.signature(run).parameters)]


def test_seeds_are_those_of_config() -> None:
    (bounds,) = Seed.__metadata__
    assert [bound.lt for bound in bounds.metadata if hasattr(bound, "lt")] == [cli.SEEDS]


@pytest.mark.parametrize("seed", [-1, 2**53, 2**63, 10**30])
def test_every_command_refuses_them(seed: int) -> None:
    commands = seeded()
    assert len(commands) >= 8
    for run in commands:
        for name in (name for name in inspect.signature(run).parameters if name.endswith("seed")):
            with refused("E-SEED", f"--{name.replace('_', '-')}: {seed} is no seed"):
                cli.with_seeds_checked(run)(**{name: seed})


def test_good_ones_pass(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[dict[str, Any]] = []

    def run(*, seed: int = 0, layout_seed: int | None = None) -> None:
        said.append({"seed": seed, "layout_seed": layout_seed})

    cli.with_seeds_checked(run)(seed=2**53 - 1, layout_seed=None)
    cli.with_seeds_checked(run)()
    assert said == [{"seed": 2**53 - 1, "layout_seed": None}, {"seed": 0, "layout_seed": None}]
    for seed in ("-1", str(2**63)):
        monkeypatch.setattr(
            sys, "argv", ["roomkin.stages.assets", "library", "--out", "none/library.json", "--seed", seed]
        )
        with pytest.raises(SystemExit) as ended:
            cli.main("roomkin.plugins.furniture", {"library": ""})
        assert ended.value.code == 1
        assert capsys.readouterr().err == f"error: --seed: {seed} is no seed. Fix: 0 to {2**53 - 1} [E-SEED]\n"


def test_progress_is_told_now_and_then(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(0, 1000, 2))  # two seconds a look
    monkeypatch.setattr("roomkin.stages.cli.time.monotonic", lambda: float(next(clock)))
    assert list(cli.progress(range(6), "models", 6)) == [*range(6)]
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2 and told[0].startswith("models: 3/6 [00:")
