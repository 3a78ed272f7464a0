"""Flags are looked at before a command is imported."""

import subprocess
import sys

import pytest

from roomkin.stages.cli import find_wrong_flag


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--otu", "x"], "there is no --otu. Fix: did you mean '--out'"),
        (["--out", "x"], "--episodes"),
        (["--bogus=3"], "there is no --bogus"),
        (["--help"], ""),
    ],
)
def test_a_wrong_flag_is_found(given: list[str], words: str) -> None:
    fault = find_wrong_flag("roomkin.stages.training.train", given)
    assert words in fault if words else not fault


def test_flags_that_are_there_are_taken() -> None:
    assert not find_wrong_flag(
        "roomkin.stages.extraction.extract", ["--input=a", "--scene", "b", "--out", "c", "--seed", "1"]
    )


def test_a_wrong_flag_ends_before_torch_is_imported() -> None:
    code = (
        "import sys; sys.argv = ['x', 'train', '--bogus']\n"
        "try:\n    import runpy; runpy.run_module('roomkin.stages.training', run_name='__main__')\n"
        "except SystemExit as end:\n    print(end.code, 'torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["2", "False"] and done.stderr.count("\n") == 1
