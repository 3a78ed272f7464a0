"""Every `python -m` that a page, an error or a comment names is there."""

import re
from collections import defaultdict

from tests.commands import list_commands
from tests.workflow.workspace import ROOT

NAMED = re.compile(r"python -m ((?:stages|plugins|benchmarks|reference)(?:\.[a-z_]\w*)+)(?: ([a-z][a-z_-]*)\b)?")
# The changelog names what was, too.
PLACES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "Makefile", "Snakefile")]
ENDINGS = {".md", ".py", ".smk", ".sh", ".yaml", ".yml", ".jinja", ".toml"}
FOLDERS = ("docs", "stages", "plugins", "rules", "benchmarks", "reference", "config", "envs")


def test_every_module_and_command_that_is_named_is_there() -> None:
    known = defaultdict(set)
    for folder, name in list_commands():
        known[folder].add(name)
    files = [*PLACES, *(path for name in FOLDERS for path in (ROOT / name).rglob("*") if path.suffix in ENDINGS)]
    missing, found = [], 0
    for file in files:
        for module, name in NAMED.findall(file.read_text(encoding="utf-8")):
            path, found = ROOT.joinpath(*module.split(".")), found + 1
            there = (path / "__main__.py").is_file() or path.with_suffix(".py").is_file()
            ours = module.count(".") == 1 and not module.startswith("benchmarks")
            spoken = known[path.relative_to(ROOT).as_posix()] if ours else set()
            if not there or (name and spoken and name not in spoken):
                missing.append(f"{file.relative_to(ROOT)}: {module} {name}")
    assert found > 100 and not missing
