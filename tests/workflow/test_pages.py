"""docs/results/machines.md says which commit made every page, and how `make paper` makes it again."""

import os
import re
import shlex
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.workflow.workspace import ROOT

RESULTS = ROOT / "docs/results"
MACHINES = RESULTS / "machines.md"
PAGES = [*sorted(RESULTS.rglob("*.md")), ROOT / "docs/benchmarks.md", ROOT / "README.md"]
COMMIT = re.compile(r"(?<![\w.#/-])[0-9a-f]{7,8}(?![\w/-]|\.\d)")
MAKE = set(re.findall(r"^([a-z0-9-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))


class Row(NamedTuple):
    """A row of the table; a step has a command, and what has none says why it is pinned."""

    step: str
    pages: str
    commits: str
    hours: str
    command: str
    pinned: str


def read_rows() -> list[Row]:
    """Rows of the table of pages."""
    text = MACHINES.read_text(encoding="utf-8")
    table = text[text.index("| step |") :].split("\n\n")[0].splitlines()[2:]
    return [Row(*(cell.strip(" `") for cell in line.strip("|").split("|"))) for line in table]


ROWS = read_rows()


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
    assert bool(row.step) == bool(row.command) != bool(row.pinned)
    if row.step:
        assert row.hours == "?" or float(row.hours) <= 48  # a day of two cores
    linked = re.findall(r"\]\(([^)]+)\)", row.pages)
    named = set[str]().union(*(commits_in((RESULTS / page).read_text(encoding="utf-8")) for page in linked))
    assert set(row.commits.split()) <= named, "no page of the row names it"


@pytest.mark.parametrize("row", [row for row in ROWS if row.step], ids=[row.step for row in ROWS if row.step])
def test_a_step_calls_what_there_is(row: Row) -> None:
    for command in row.command.split(" && "):
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
    """A benchmark, or a verb of a package, has these flags; files that are named are there."""
    if module.name == "__init__.py":
        main = module.with_name("__main__.py")
        module = main if "add_argument" in main.read_text(encoding="utf-8") else module.with_name(f"{words[0]}.py")
    text = module.read_text(encoding="utf-8")
    for flag in (word.removeprefix("--") for word in words if word.startswith("--")):
        assert f'"--{flag}"' in text or re.search(rf"^    {flag}: ", text, re.MULTILINE), (module, flag)


def test_the_plan_has_every_row() -> None:
    plan = run_paper(ROOT, "--list")
    assert plan.returncode == 0, plan.stderr
    steps = [line.split()[0] for line in plan.stdout.splitlines() if not line.startswith("pinned: ")]
    assert steps == [row.step for row in ROWS if row.step] and len(set(steps)) == len(steps)
    assert plan.stdout.count("pinned: ") == len(ROWS) - len(steps)


def run_paper(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`make paper`, but for the environment."""
    command = ["bash", folder / "config/study/paper.sh", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A repository with two steps: one counts how often it ran, one fails until `mended` is there."""
    for name in ("config/study", "docs/results"):
        (tmp_path / name).mkdir(parents=True)
    shutil.copy(ROOT / "config/study/paper.sh", tmp_path / "config/study")
    rows = ("| `fails` | [a](a.md) | | ? | `cat mended` | |", "| `count` | | | 1 | `echo ran >>results/count` | |")
    table = ("| step | pages | commits | hours | command | pinned, because |", "|---|---|---|---|---|---|", *rows)
    (tmp_path / "docs/results/machines.md").write_text("\n".join([*table, "| | [b](b.md) | 1234abc | 9 | | old |", ""]))
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

    first = run_paper(small)
    assert first.returncode == 1 and "fails failed" in first.stderr and count() == 1
    (small / "mended").touch()
    assert run_paper(small).returncode == 0 and count() == 1
    (small / "docs/results/new.md").touch()
    commit(small, "results alone")
    assert run_paper(small).returncode == 0 and count() == 1
    made = (small / "results/paper/count.txt").read_text().strip()
    (small / "code.py").touch()
    commit(small, "code again")
    plan = run_paper(small, "--list").stdout.splitlines()
    assert plan[1].split() == ["count", made, "1", "h", "echo", "ran", ">>results/count"]
    assert plan[2].rstrip() == "pinned: b by 1234abc: old"
    assert run_paper(small).returncode == 0 and count() == 2
    assert run_paper(small, "--list").stdout.count(" done ") == 2


def test_no_step_runs_on_files_that_no_commit_has(small: Path) -> None:
    (small / ".gitignore").write_text("/results/\n")
    done = run_paper(small)
    assert done.returncode == 1 and "git commit" in done.stderr and not (small / "results/count").exists()
