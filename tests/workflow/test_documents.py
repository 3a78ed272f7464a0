"""Every command and every YAML block of README and docs does what the page says: no block is only prose."""

import json
import re
import shlex
import shutil
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from typing import NamedTuple

import pytest
import yaml

from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.config.model import load, merge_mappings, with_defaults
from roomkin.stages.config.packages import home_of
from roomkin.stages.config.weights import DINOV2, is_there
from roomkin.workflow import COMMANDS, ELSEWHERE, list_homes
from tests.commands import list_passed_flags, read_flags
from tests.workflow.workspace import ROOT, make, plan, put

GUIDES = [path for folder in ("docs", "docs/tutorial") for path in sorted((ROOT / folder).glob("*.md"))]
REFERENCE = {f"{name}.md" for name in ("architecture", "benchmarks", "config", "contracts", "glossary", "tables")}
PAGES = [ROOT / "README.md", ROOT / "config/README.md", *GUIDES]
FENCE = re.compile(
    r"(?:^ *<!-- not run: (?P<why>[^\n]+) -->\n)?^ *```(?P<kind>\w*)\n(?P<text>.*?)^ *```", re.DOTALL | re.MULTILINE
)
OURS = re.compile(r"^(\.venv/bin/)?(snakemake|roomkin |make |source )")
# The package of docs/extending.md is run by tests/unit/test_extending.py; a page's room file by the test of that room.
PACKAGE = re.compile("my_package|colors")


class Block(NamedTuple):
    """A fenced block of a page; `why` it is not run, if the page says so."""

    page: str
    kind: str
    text: str
    why: str | None


def blocks(*kinds: str) -> list[Block]:
    """Blocks of some kinds in all pages."""
    found = [
        Block(
            page.name if page.parent != ROOT / "config" else "config", each["kind"], dedent(each["text"]), each["why"]
        )
        for page in PAGES
        for each in FENCE.finditer(page.read_text(encoding="utf-8"))
        if not (page.name == "extending.md" and PACKAGE.search(each["text"]))
    ]
    return [block for block in found if block.kind in kinds and block.why is None]


def commands() -> list[tuple[str, str]]:
    """Page and command, comments and line breaks taken away."""
    found = []
    for block in blocks("bash", "sh", ""):
        lines = [re.sub(r"\s+# .*|^# .*", "", line) for line in block.text.replace("\\\n", " ").splitlines()]
        found += [(block.page, line.strip()) for line in lines if line.strip()]
    once = {line: page for page, line in reversed(found)}
    return [(page, line) for line, page in once.items() if OURS.match(line)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone in which the files stand that the pages speak of."""
    folder = make(tmp_path_factory.mktemp("clone"))
    for name in INPUT_FILES:
        put(folder / "my/kitchen" / name)
    table = ("scene,folder", "shelf,kitchen")
    (folder / "my/pictures.csv").write_text("\n".join(table))
    shutil.copytree(folder / "my/kitchen", folder / "my/folders/hall")
    known = {"version": 1, "objects": [{"mask": 1, "label": "cabinet", "articulated": True, "doors": 1}]}
    (folder / "my/kitchen/annotations.json").write_text(json.dumps(known))
    shutil.copytree(folder / "my/kitchen", folder / "kitchen")
    for name in ("my/assets/chair/one.urdf", "mine.sh", "lib/part.sh", "my_matching.py"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch(mode=0o755)
    (folder / "mine.yaml").write_text("experiment: {targets: {door: null}}")
    for block in blocks("yaml"):
        if block.text.startswith("# attic.yaml"):
            (folder / "attic.yaml").write_text(block.text)
    return folder


@pytest.mark.parametrize("block", blocks("yaml"), ids=lambda block: block.page)
def test_a_yaml_block_is_a_config(folder: Path, monkeypatch: pytest.MonkeyPatch, block: Block) -> None:
    if block.text.startswith("# attic.yaml"):
        pytest.skip("a room, which the block after it names")
    if "encoder: dinov2" in block.text and not is_there(DINOV2):
        pytest.skip("no weights of DINOv2")
    monkeypatch.chdir(folder)
    default = with_defaults({})
    load(merge_mappings(default, yaml.safe_load(block.text)))


@pytest.mark.parametrize(("page", "line"), commands(), ids=[line[:60] for _, line in commands()])
def test_a_command_is_one(folder: Path, page: str, line: str) -> None:
    words = shlex.split(line.removeprefix(".venv/bin/"))
    if words[0] == "make":
        assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(), re.MULTILINE)
    elif words[0] == "python":
        check_flags(words[2], words[3:])
    elif words[0] == "roomkin":
        check_roomkin(words[1:])
    elif words[0] == "snakemake":
        check_snakemake(folder, words[1:])
    else:
        assert words == ["source", ".venv/bin/activate"]


def check_flags(package: str, words: list[str]) -> None:
    """A command of a stage or package takes these flags, and needs no others."""
    folder = ROOT / package.replace(".", "/")
    if not folder.is_dir():  # doctor
        assert folder.with_suffix(".py").is_file() and words in ([], ["--slurm"])
        return
    if package in ("roomkin.stages.config", "roomkin.stages.contracts"):
        return
    given = {word for word in words if word.startswith("--")}
    known, needed = read_flags(folder, words[0])
    assert "--help" in given or (given <= known and needed <= given), (sorted(given - known), sorted(needed - given))


def check_roomkin(words: list[str]) -> None:
    """A word of its own, or a stage or package with its command; with flags that it takes."""
    word, *given = words
    module, *command = ELSEWHERE.get(word, ["roomkin", word]) if word in COMMANDS else [list_homes()[word]]
    check_flags(module, [*command, *given])


def check_snakemake(folder: Path, words: list[str]) -> None:
    """A dry run of it plans something; what needs a finished run or a plugin is only parsed."""
    if {"profiles/slurm", "profiles/kubernetes", "profiles/apptainer"} & set(words):
        from snakemake.cli import get_argument_parser

        assert get_argument_parser().parse_args(words)
        return
    configs = [ROOT / word for word in words if word.endswith(".yaml") and (ROOT / word).is_file()]
    if any("encoder: dinov2" in path.read_text(encoding="utf-8") for path in configs) and not is_there(DINOV2):
        pytest.skip("no weights of DINOv2")
    kept = [word for before, word in pairwise(["", *words]) if "--cores" not in (before, word) and word != "-n"]
    done = plan(folder, *kept)
    assert done.returncode == 0 and "total" in done.stdout, done.stdout[-3000:]


def test_the_workflow_passes_flags_that_the_commands_have() -> None:
    passed = list_passed_flags()
    assert len(passed) > 40
    for (stage, command), words in passed.items():
        known, needed = read_flags(ROOT / home_of(stage).replace(".", "/"), command)
        assert needed <= words <= known, (stage, command)


def test_what_is_not_run_says_why() -> None:
    for page in PAGES:
        for each in FENCE.finditer(page.read_text(encoding="utf-8")):
            assert each["why"] is None or len(each["why"]) > 10


def test_readme_fits_on_a_screen_and_guides_into_an_hour() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 60
    words = {path.name: len(path.read_text(encoding="utf-8").split()) for path in GUIDES if path.name not in REFERENCE}
    assert sum(words.values()) <= 15_000, words


def test_the_glossary_is_short_and_prose_can_be_read() -> None:
    rows = [line for line in (ROOT / "docs/glossary.md").read_text(encoding="utf-8").splitlines() if line[:2] == "| "]
    assert len(rows) - 1 <= 25
    pages = [path for path in GUIDES if path.name not in REFERENCE] + sorted((ROOT / "docs/results").glob("*.md"))
    assert sum(map(prose, pages)) <= 25_000


def prose(page: Path) -> int:
    """Words of a page outside of tables and code."""
    lines = FENCE.sub("", page.read_text(encoding="utf-8")).splitlines()
    return sum(len(line.split()) for line in lines if not line.lstrip().startswith("|"))


def test_lines_of_prose_are_short() -> None:
    for page in [*PAGES, ROOT / "CONTRIBUTING.md"]:
        lines = FENCE.sub("", page.read_text(encoding="utf-8")).splitlines()
        assert not [line for line in lines if len(line) > 400 and not line.startswith("|")], page


def test_pictures_are_small() -> None:
    sizes = {path.name: path.stat().st_size for path in (ROOT / "docs/images").iterdir()}
    assert sizes.pop("hero.webp") < 1_500_000 and sizes.pop("first_policy.webp") < 400_000  # they move
    assert not [name for name, size in sizes.items() if size > 150_000]


def test_pages_that_code_and_configs_name_are_there() -> None:
    folders = ("stages", "plugins", "rules", "config", "benchmarks", "containers", "profiles", "envs", "reference")
    files = [
        path
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".smk", ".yaml", ".md", ".sh")
    ]
    named = {page for path in [*files, ROOT / "Makefile"] for page in re.findall(r"docs/[\w/-]+\.md", path.read_text())}
    assert not [page for page in sorted(named) if not (ROOT / page).is_file()]
