"""The workflows of GitHub run what .ci/run and the Makefile have, with no more rights than they need."""

import os
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.workflow.workspace import ROOT

FILES = sorted((ROOT / ".github/workflows").glob("*.yml"))
TARGETS = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def jobs(file: Path) -> list[dict[str, Any]]:
    """The jobs of a workflow."""
    return list(yaml.safe_load(file.read_text())["jobs"].values())


def commands(file: Path) -> list[str]:
    """The lines that a workflow runs in a shell."""
    return [line for job in jobs(file) for step in job.get("steps", []) for line in step.get("run", "").splitlines()]


def test_the_tests_are_those_that_gate_a_landing() -> None:
    lines = commands(ROOT / ".github/workflows/test.yml")
    assert [line.removeprefix("sudo ") for line in lines] == [".ci/run", "make wheel"]
    assert os.access(ROOT / ".ci/run", os.X_OK)
    (caller, release) = jobs(ROOT / ".github/workflows/release.yml")
    assert caller["uses"] == "./.github/workflows/test.yml" and release["needs"] == "test"


def test_what_is_released_is_what_the_tests_made() -> None:
    made = {
        step["with"]["name"]: step["with"]["path"]
        for step in jobs(FILES[1])[0]["steps"]
        if "name" in step.get("with", {})
    }
    assert made == {"wheel": "dist/", "site": "site/"}
    assert all(f"made/{name}" in (ROOT / ".github/workflows/release.yml").read_text() for name in made)


@pytest.mark.parametrize("text", [*(file.read_text() for file in FILES), (ROOT / ".ci/run").read_text()])
def test_every_target_is_in_the_makefile(text: str) -> None:
    assert set(re.findall(r"^ *(?:run: )?(?:sudo )?make ([\w-]+)", text, re.MULTILINE)) <= TARGETS


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_actions_are_pinned_and_nothing_may_do_more_than_it_needs(file: Path) -> None:
    text = file.read_text()
    for name in re.findall(r"uses: (\S+.*)", text):
        assert name.startswith("./") or re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", name), name
    assert yaml.safe_load(text)["permissions"] == {}
    rights = [job["permissions"] for job in jobs(file)]
    assert all(right in ({"contents": "read"}, {"contents": "write"}) for right in rights)
    assert ("write" in text) == (file.name == "release.yml")
    assert yaml.safe_load(text)["concurrency"]["group"] == file.stem + "-${{ github.ref }}"  # each its own: no deadlock
    assert "actions/checkout" not in text or "persist-credentials: false" in text
