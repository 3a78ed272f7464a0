"""docs/results/machines.md says which commit made every page, and how `make paper` makes it again."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from tests.workflow.workspace import ROOT

RESULTS = ROOT / "docs/results"
MACHINES = RESULTS / "machines.md"
STUDIES = ROOT / "plugins/studies"
PAGES = [*sorted(RESULTS.rglob("*.md")), ROOT / "docs/benchmarks.md", ROOT / "README.md"]
COMMIT = re.compile(r"(?<![\w.#/-])[0-9a-f]{7,8}(?![\w/-]|\.\d)")
MAKE = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))


class Row(NamedTuple):
    """A row of the table: what no step makes again says why it is pinned."""

    step: str
    pages: str
    commits: str
    pinned: str


def read_rows() -> list[Row]:
    """Rows of the table of pages."""
    text = MACHINES.read_text(encoding="utf-8")
    table = text[text.index("| step |") :].split("\n\n")[0].splitlines()[2:]
    return [Row(*(cell.strip(" `") for cell in line.strip("|").split("|"))) for line in table]


ROWS = read_rows()
STEPS = yaml.safe_load((STUDIES / "paper.yaml").read_text(encoding="utf-8"))


def commits_in(text: str) -> set[str]:
    """Commits that a text names: seven or eight hex digits, a letter and a figure among them, or after "commit"."""
    named = set()
    for found in COMMIT.finditer(text):
        mixed = re.search(r"[a-f]", found[0]) and re.search(r"\d", found[0])
        if mixed or re.search(r"[Cc]ommits?:? `?$", text[: found.start()]):
            named.add(found[0])
    return named


def rows_of(page: str) -> list[Row]:
    """Rows that link to a page, a path from docs/results."""
    return [row for row in ROWS if f"]({page})" in row.pages]


def test_commits_are_told_from_dates_sizes_and_words() -> None:
    text = "9264e0d (commit 3517852, Commit: `9853073`), decade1; 20210327, .84375a1, acceded, 0448efd/x"
    assert commits_in(text) == {"9264e0d", "3517852", "9853073", "decade1"}


@pytest.mark.parametrize("page", PAGES, ids=[path.name for path in PAGES])
def test_a_page_names_the_commits_of_its_rows(page: Path) -> None:
    name = os.path.relpath(page, RESULTS)
    text = page.read_text(encoding="utf-8")
    if page == MACHINES:
        text = re.sub(r"^\|.*", "", text, flags=re.MULTILINE)
    rows = rows_of(name)
    assert rows or page.name == "README.md", f"{name}: no row of docs/results/machines.md"
    stray = commits_in(text) - {commit for row in rows for commit in row.commits.split()}
    assert not stray, f"{name}: names {stray}, which no row of docs/results/machines.md has for it"


@pytest.mark.parametrize("row", ROWS, ids=[row.step or row.pages for row in ROWS])
def test_a_row_is_a_step_or_says_why_it_is_pinned(row: Row) -> None:
    assert bool(row.step) != bool(row.pinned)
    linked = re.findall(r"\]\(([^)]+)\)", row.pages)
    named = set[str]().union(*(commits_in((RESULTS / page).read_text(encoding="utf-8")) for page in linked))
    assert set(row.commits.split()) <= named, "no page of the row names it"


def test_the_page_has_a_row_of_every_step() -> None:
    assert [row.step for row in ROWS if row.step] == list(STEPS)


@pytest.mark.parametrize("step", STEPS)
def test_a_step_calls_what_there_is(step: str) -> None:
    assert set(STEPS[step]) <= {"run", "hours", "after"} and STEPS[step].get("hours", 0) <= 48  # a day of two cores
    for command in STEPS[step]["run"].split(" && "):
        words = [word for word in shlex.split(command) if not re.match(r"[A-Z_]+=", word)]
        if words[0] == "make":
            assert words[1] in MAKE
        elif words[1:2] == ["-m"]:
            found = find_spec(words[2])
            assert found and found.origin, words[2]
            check_flags(Path(found.origin), words[3:])
        else:
            assert words[0] in ("snakemake", "pip", "mkdir", "tar", "rm", "bash")
            assert not [
                word for word in words if word.endswith((".yaml", ".sh", ".xz")) and not (ROOT / word).is_file()
            ]


def check_flags(module: Path, words: list[str]) -> None:
    """A benchmark, or a command of a package, has these flags; files that are named are there."""
    if module.name == "__init__.py":
        main = module.with_name("__main__.py")
        module = main if "add_argument" in main.read_text(encoding="utf-8") else module.with_name(f"{words[0]}.py")
    text = module.read_text(encoding="utf-8")
    for flag in (word.removeprefix("--") for word in words if word.startswith("--")):
        assert f'"--{flag}"' in text or re.search(rf"^    {flag}: ", text, re.MULTILINE), (module, flag)


def run_paper(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`make paper`, but for the environment."""
    snakemake = [Path(sys.executable).with_name("snakemake"), "--cores", "1", "--keep-going"]
    file = ["--snakefile", folder / "plugins/studies/paper.smk", "--directory", folder / "results/paper"]
    return subprocess.run([*snakemake, *file, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_the_plan_has_every_step(tmp_path: Path) -> None:
    shutil.copytree(STUDIES, tmp_path / "plugins/studies")
    commit(tmp_path, "code")
    plan = run_paper(tmp_path, "-n")
    assert plan.returncode == 0, plan.stderr
    assert re.search(rf"^step +{len(STEPS)}$", plan.stdout, re.MULTILINE), plan.stdout


STEPS_OF_TWO = """
fails: {run: cat mended}
count: {run: echo ran >> results/count && echo by $COMMIT}
later: {run: echo never, after: [fails]}
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A repository with steps: one counts how often it ran, one fails until `mended` is there."""
    (tmp_path / "plugins/studies").mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    shutil.copy(STUDIES / "paper.smk", tmp_path / "plugins/studies")
    (tmp_path / "plugins/studies/paper.yaml").write_text(STEPS_OF_TWO)
    (tmp_path / ".gitignore").write_text("/results/\nmended\n")
    commit(tmp_path, "code")
    return tmp_path


def commit(folder: Path, message: str) -> None:
    """Everything in the folder."""
    who = ("-c", "user.name=a", "-c", "user.email=a@b")
    for words in (("init", "-q"), ("add", "."), (*who, "commit", "-q", "-m", message)):
        subprocess.run(["git", *words], cwd=folder, check=True)


def test_a_step_runs_once_a_commit_of_the_code(small: Path) -> None:
    def count() -> int:
        return (small / "results/count").read_text().count("ran")

    def made() -> list[str]:
        return sorted(path.stem for path in (small / "results/paper").glob("*/*.done"))

    first = run_paper(small)
    assert first.returncode == 1 and count() == 1 and made() == ["count"], first.stderr
    (small / "mended").touch()
    (small / "docs/new.md").touch()
    commit(small, "results alone")
    assert run_paper(small).returncode == 0 and count() == 1 and made() == ["count", "fails", "later"]
    (log,) = (small / "results/paper").glob("*/count.log")
    assert log.read_text().splitlines() == [f"by {log.parent.name}"]
    (small / "code.py").touch()
    commit(small, "code again")
    assert run_paper(small).returncode == 0 and count() == 2 and len(made()) == 6


def test_no_step_runs_or_counts_on_files_that_no_commit_has(small: Path) -> None:
    (small / "plugins/studies/paper.yaml").write_text("change: {run: touch code.py && git add code.py}\n")
    refused = run_paper(small)
    assert refused.returncode == 1 and "git commit" in refused.stderr
    commit(small, "a step that changes code")
    changed = run_paper(small)
    assert changed.returncode == 1 and not list((small / "results/paper").glob("*/*.done"))
    assert "code changed meanwhile" in next((small / "results/paper").glob("*/change.log")).read_text()
