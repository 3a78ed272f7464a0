"""A run prints a line a job and what is wrong; Snakemake's own words on demand."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RULES = """
rule all:
    input: "a_kitchen.txt"
rule make_text:
    output: "{letter}_{room}.txt"
    log: "logs/{letter}_{room}.log"
    shell: "echo doubt: a chair >&2; CODE && touch {output}"
"""


def run(folder: Path, code: str, *arguments: str, **environment: str) -> list[str]:
    """The lines that Snakemake prints of a workflow of two jobs, by our profile."""
    (folder / "Snakefile").write_text(RULES.replace("CODE", code))
    snakemake = Path(sys.executable).with_name("snakemake")
    done = subprocess.run(
        [snakemake, "--cores", "1", "--workflow-profile", ROOT / "profiles/default", *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT), "HOME": str(folder), **environment},
    )  # fmt: skip
    return [line for line in done.stdout.splitlines() if line and not line.startswith("Using workflow")]


def test_a_line_a_job_and_what_jobs_say_themselves(tmp_path: Path) -> None:
    first, said, *ends = run(tmp_path, "sleep 1.2")
    assert (first, said) == ("2 jobs, a line as each ends", "doubt: a chair")
    assert ends[0] in {f"[1/2] make text a kitchen  {seconds} s" for seconds in range(1, 9)}
    assert ends[1].startswith("[2/2] all  ") and len(ends) <= 3
    assert run(tmp_path, "sleep 1.2") == ["Nothing to be done (all requested files are present and up to date)."]


def test_a_job_that_fails_is_named_with_its_log(tmp_path: Path) -> None:
    lines = run(tmp_path, "false")
    assert any(
        line.startswith("FAILED make text a kitchen  ") and line.endswith("logs/a_kitchen.log") for line in lines
    )
    assert not any("Exiting" in line or "completed" in line for line in lines)


@pytest.mark.parametrize(("arguments", "environment"), [(["-n"], {}), (["--verbose"], {}), ([], {"VERBOSE": "1"})])
def test_all_of_snakemakes_words_on_demand(tmp_path: Path, arguments: list[str], environment: dict[str, str]) -> None:
    lines = run(tmp_path, "true", *arguments, **environment)
    assert any("reason: " in line for line in lines) and not any("a line as each ends" in line for line in lines)


def test_quiet_is_quieter(tmp_path: Path) -> None:
    assert [line for line in run(tmp_path, "true", "--quiet") if "Elapsed" not in line] == ["doubt: a chair"]
    assert run(tmp_path, "false", "--quiet", "all") == ["doubt: a chair"]
