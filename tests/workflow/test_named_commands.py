"""Every command of ours that a page, an error or a comment names is there."""

import re
from collections import defaultdict

from roomkin.workflow import COMMANDS, list_homes
from tests.commands import list_commands
from tests.workflow.workspace import ROOT

NAMED = re.compile(r"python -m ((?:roomkin|benchmarks|reference)(?:\.[a-z_]\w*)+)(?: ([a-z][a-z_-]*)\b)?")
TYPED = re.compile(r"(?:`|: |^)roomkin ([a-z][a-z_-]*)(?: ([a-z][a-z_-]*)\b)?", re.MULTILINE)
# The changelog names what was, too.
PLACES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "Makefile", "Snakefile")]
ENDINGS = {".md", ".py", ".smk", ".sh", ".yaml", ".yml", ".jinja", ".toml"}
FOLDERS = ("docs", "roomkin", "stages", "plugins", "rules", "benchmarks", "reference", "config", "envs")


def test_every_module_and_command_that_is_named_is_there() -> None:
    known, homes = defaultdict(set), list_homes()
    for folder, name in list_commands():
        known[folder].add(name)
    files = [*PLACES, *(path for name in FOLDERS for path in (ROOT / name).rglob("*") if path.suffix in ENDINGS)]
    missing, found = [], 0
    for file in files:
        text = file.read_text(encoding="utf-8")
        named = [
            (homes.get(word, f"roomkin.{word}"), name) for word, name in TYPED.findall(text) if word not in COMMANDS
        ]
        for module, name in [*NAMED.findall(text), *named]:
            path, found = ROOT.joinpath(*module.split(".")), found + 1
            there = (path / "__main__.py").is_file() or path.with_suffix(".py").is_file()
            spoken = known[path.relative_to(ROOT / "roomkin").as_posix()] if module in homes.values() else set()
            if not there or (name and spoken and name not in spoken):
                missing.append(f"{file.relative_to(ROOT)}: {module} {name}")
    assert found > 100 and not missing
