"""Dry runs: every shipped config makes a DAG, every rule is declared as it should be, mistakes are explained."""

import re
from pathlib import Path

import pytest
import yaml

from stages.config import reference
from tests.workflow.workspace import ROOT, make, snakemake

OVERLAYS = sorted(path.relative_to(ROOT) for path in (ROOT / "config").rglob("*.yaml"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("dag"))


@pytest.mark.parametrize("overlay", [None, *OVERLAYS], ids=str)
def test_every_shipped_config_has_a_dag(folder: Path, overlay: Path | None) -> None:
    files = ["config.yaml"] + ([str(overlay)] if overlay else [])
    done = snakemake(folder, "-n", "--quiet", "all", "--configfile", *files, "--", "all")
    assert done.returncode == 0, done.stdout


def test_all_eight_rooms_can_be_asked_for(folder: Path) -> None:
    done = snakemake(folder, "-n", "scenes8")
    assert re.search(r"^room\s+8$", done.stdout, re.MULTILINE), done.stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("matching: {encodr: hog}", "did you mean 'encoder'?"),
        ("maching: {encoder: hog}", "did you mean 'matching'?"),
        ("matching: {encoder: resnet}", "matching.encoder"),
        ("experiment: {rooms: [room_9]}", "unknown scene 'room_9'"),
        ("experiment: {runs: [huge]}", "'huge' is not one of training.runs"),
        ("experiment: {variants: {b: {k_modl: 3}}}", "k_modl"),
    ],
)
def test_a_wrong_config_is_one_clear_line(folder: Path, tmp_path: Path, text: str, message: str) -> None:
    overlay = tmp_path / "mine.yaml"
    overlay.write_text(text)
    done = snakemake(folder, "-n", "--configfile", "config.yaml", str(overlay), "--", "all")
    assert done.returncode == 1
    assert message in done.stdout
    assert "Traceback" not in done.stdout


def test_generated_files_are_up_to_date() -> None:
    for name, text in reference.generate().items():
        assert (ROOT / name).read_text(encoding="utf-8") == text, f"{name} drifted from stages/config; run: make config"


def test_config_yaml_holds_every_key() -> None:
    config = yaml.safe_load((ROOT / "config.yaml").read_text(encoding="utf-8"))
    assert set(config) == set(reference.Config.model_fields)


def rules_text() -> dict[str, str]:
    """Body of every rule by name."""
    text = "\n".join(path.read_text() for path in sorted((ROOT / "rules").glob("*.smk")))
    parts = re.split(r"^rule (\w+):$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def test_every_working_rule_has_container_log_threads_and_code() -> None:
    for name, body in rules_text().items():
        if "localrule: True" in body:
            continue
        for directive in ("container:", "log:", "threads:", "resources:", "params:", "shell:", " code="):
            assert directive in body, f"rule {name} lacks {directive}"


def test_podman_profile_covers_every_working_rule() -> None:
    profile = yaml.safe_load((ROOT / "profiles/podman/config.yaml").read_text())
    working = {name for name, body in rules_text().items() if "localrule: True" not in body}
    assert set(profile["set-resources"]) == working
    for name, body in rules_text().items():
        if name in working:
            family = re.search(r"CONFIG\.containers\.(\w+)", body)
            assert family and profile["set-resources"][name]["shell_exec"] == f"containers/sh-{family[1]}"


def test_files_stay_small() -> None:
    assert len((ROOT / "Snakefile").read_text().splitlines()) <= 80
    for path in (ROOT / "rules").glob("*.smk"):
        assert len(path.read_text().splitlines()) <= 170, path.name
    for path in (ROOT / "stages").rglob("*.py"):
        assert len(path.read_text().splitlines()) <= 300, path.name
