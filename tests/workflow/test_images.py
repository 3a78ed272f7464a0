"""What a rule runs is imported with nothing but its image's packages: `envs/<family>.txt`."""

import re
import subprocess
import sys
from collections import defaultdict

import pytest

from roomkin.stages.cli import find_module
from tests.commands import list_commands, list_rule_files
from tests.workflow.workspace import ROOT

FAMILY = re.compile(r"CONFIG\.containers\.(\w+)")
COMMAND = re.compile(r'\*\*command\(\s*"(\w+)",\s*"([\w-]+)"')

IMPORTS = """
import importlib, importlib.metadata, re, sys
def plain(name): return re.sub(r"[-_.]+", "-", name).lower()
lines = open(sys.argv[1]).read().splitlines()
there = {plain(line.split("==")[0]) for line in lines if "==" in line and not line.startswith(("#", " "))}
packages = importlib.metadata.packages_distributions().items()
OURS = {"roomkin", "reference", "benchmarks", "tests"}
missing = {name for name, of in packages if name not in OURS and not there & {plain(each) for each in of}}
class Image:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] not in missing:
            return next((spec for each in finders if (spec := each.find_spec(name, path, target))), None)
    def find_distributions(self, context):
        found = (each.find_distributions(context) for each in finders if hasattr(each, "find_distributions"))
        return (one for group in found for one in group if plain(one.metadata["Name"]) in there)
finders, sys.meta_path[:] = sys.meta_path[:], [Image()]
for name in sys.argv[2:]:
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        print(f"{name}: {error}")
"""


def list_modules() -> dict[str, set[str]]:
    """Modules of the commands that rules run, by the family of the rule's image."""
    folders = {folder.rpartition("/")[2]: f"roomkin.{folder.replace('/', '.')}" for folder, _ in list_commands()}
    found: dict[str, set[str]] = defaultdict(set)
    for path in list_rule_files():
        head, *rules = re.split(r"^ *(?:rule|checkpoint) \w+:$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
        usual = FAMILY.search(head)
        for text in rules:
            own = FAMILY.search(text) or usual
            for stage, name in COMMAND.findall(text):
                assert own, f"{path}: {stage} {name} has no image"
                found[own[1]].add(f"{folders[stage]}.{find_module(name)}")
    return found


def test_every_command_of_a_rule_is_found() -> None:
    found = set().union(*list_modules().values())
    known = {f"roomkin.{folder.replace('/', '.')}.{find_module(name)}" for folder, name in list_commands()}
    assert len(found) > 40 and found <= known


@pytest.mark.parametrize("family", ["report", "learning", "simulation"])
def test_rules_import_what_their_image_has(family: str) -> None:
    modules = sorted(list_modules()[family])
    command = [sys.executable, "-c", IMPORTS, str(ROOT / f"envs/{family}.txt"), *modules]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert modules and done.stdout == ""


def test_what_an_image_lacks_is_refused() -> None:
    command = [sys.executable, "-c", IMPORTS, str(ROOT / "envs/report.txt"), "trimesh"]
    assert "trimesh" in subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
