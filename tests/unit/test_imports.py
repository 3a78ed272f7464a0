"""What importing costs: which of the large libraries a command loads before it does anything, and the API."""

import json
import subprocess
import sys

from roomkin.stages.cli import find_module
from tests.commands import list_commands
from tests.packages import needs
from tests.workflow.workspace import ROOT

# By what is loaded, also for `--help` of the command; one that is not here loads none of them.
LOADS = {
    "matplotlib": "tables.scenes tables.policies report.report report.overview report.picture studies.results",
    "open3d": "extraction.extract",
    "open3d sapien": "generation.generate",
    "sapien": "exports.scenes importing.own pictures.scenes scenes.render",
    "torch": "training.train perception.see perception.draw annotator.after annotator.annotate exports.policy",
    "mani_skill matplotlib sapien torch": "importing.import",
    "mani_skill matplotlib open3d sapien torch": "demonstrations.collect evaluation.selection-rollout"
    " evaluation.rollout in_scene.demonstrate scripted.skill",
}
# One start of Python: what loads nothing large is imported first, then a fork for each group of modules.
LOOK = """\
import contextlib, importlib, io, json, os, re, runpy, sys

groups = json.load(sys.stdin)
large = {name for names in groups for name in names.split()}
loaded = lambda: " ".join(sorted(large & sys.modules.keys()))
from roomkin import make_library, make_scenes
megabytes = int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) >> 10
found = {"the API": loaded()}
for module in groups.pop("--help"):
    sys.argv = [module, "--help"]
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
        runpy.run_module(module, run_name="__main__")
    found[f"{module} --help"] = loaded()
for module in groups.pop(""):
    importlib.import_module(module)
    found[module] = loaded()
for modules in groups.values():
    read, write = os.pipe()
    if not os.fork():
        for module in modules:
            name, _, attribute = module.partition(":")
            getattr(importlib.import_module(name), attribute or "__name__")
            os.write(write, json.dumps([module, loaded()]).encode() + b"\\n")
        os._exit(0)
    os.close(write)
    os.wait()
    with open(read) as lines:
        found.update(map(json.loads, lines))
print(json.dumps([megabytes, found]))
"""


@needs("api", "films")
def test_a_command_and_the_api_load_what_is_listed_and_no_more() -> None:
    commands = {f"{folder.partition('/')[2]}.{name}": folder for folder, name in list_commands()}
    modules = {
        one: f"roomkin.{home.replace('/', '.')}.{find_module(one.partition('.')[2])}" for one, home in commands.items()
    }
    groups = {large: [modules.pop(one) for one in names.split() if one in modules] for large, names in LOADS.items()}
    groups["torch"].append("roomkin:load_policy")
    groups["mani_skill matplotlib open3d sapien torch"].append("roomkin:write_film")
    groups[""] = sorted(modules.values())
    groups["--help"] = sorted({f"roomkin.{home.replace('/', '.')}" for home in commands.values()})
    groups["--help"] += ["roomkin", "roomkin.stages.config", "roomkin.stages.contracts", "roomkin.plugins.ops.doctor"]
    looked = subprocess.run(
        [sys.executable, "-c", LOOK], input=json.dumps(groups), cwd=ROOT, capture_output=True, text=True
    )
    assert looked.returncode == 0, looked.stderr[-3000:]
    megabytes, found = json.loads(looked.stdout)
    plain = {"the API", *groups.pop(""), *(f"{module} --help" for module in groups.pop("--help"))}
    wanted = dict.fromkeys(plain, "") | {module: large for large, some in groups.items() for module in some}
    assert found == wanted
    assert megabytes < 150  # of 300 that are allowed; with torch 700
