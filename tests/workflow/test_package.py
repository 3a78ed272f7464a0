"""The package as others install it: built by the pinned tools, whole, and of use without Snakemake."""

import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml

from tests.workflow.workspace import ROOT

UV = Path(sys.executable).with_name("uv")
# In an environment of its own: what a robot learner does with it.
USE = """\
import sys
from pathlib import Path

sys.modules["snakemake"] = None  # an import of it fails
import gymnasium
import roomkin.stages
from roomkin import load_policy, models_of
from roomkin.stages.contracts import TaskAssets, read_json

results = Path(sys.argv[1])
plan = read_json(TaskAssets, next(results.glob("experiment/*/door/assets.json")))
model = models_of(results / "assets/library/library.json")[plan.assets[0].asset]
policy = load_policy(next(results.glob("training/door/micro/twin/*/seed_0")), action="most_likely")
env = gymnasium.make(policy.env_id, asset_folder=model, options=policy.task_options)
seen, _ = env.reset(seed=1)
policy.reset(seed=1)
env.step(policy.act(seen))
print(Path(roomkin.stages.__file__).parent)
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist, and with the wheel that was made from it."""
    folder = tmp_path_factory.mktemp("dist")
    command = [UV, "build", "--quiet", "--offline", "--no-build-isolation", "--python", sys.executable]
    subprocess.run([*command, "--out-dir", folder, ROOT], check=True)
    return folder


def names() -> set[str]:
    """Files below the package, those that its links lead to, too, but tests."""
    folders = [ROOT / "roomkin", *(link for link in (ROOT / "roomkin").iterdir() if link.is_dir())]
    links = [*folders, ROOT / "roomkin/profiles/default"]
    files = {path.relative_to(ROOT) for folder in links for path in folder.rglob("*") if path.is_file()}
    return {file.as_posix() for file in files if not {"__pycache__", "tests"} & set(file.parts)}


def test_the_wheel_has_one_package_with_every_file(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    inside = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert inside == names()


def test_one_version(built: Path) -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert {path.name for path in built.glob("roomkin-*")} == {
        f"roomkin-{version}-py3-none-any.whl",
        f"roomkin-{version}.tar.gz",
    }
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    released = re.findall(r"^## (\d\S+) - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert released[0] == (version, str(cited["date-released"])) and cited["version"] == version


@pytest.fixture(scope="module")
def site(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site-packages of an environment with the wheel, beside packages of other people called as ours were."""
    (wheel,), folder = built.glob("*.whl"), tmp_path_factory.mktemp("venv")
    subprocess.run([UV, "venv", "--quiet", "--offline", "--python", sys.executable, folder], check=True)
    python = folder / "bin/python"
    subprocess.run([UV, "pip", "install", "--quiet", "--offline", "--no-deps", "--python", python, wheel], check=True)
    site = next((folder / "lib").glob("*/site-packages"))
    (site / "pinned.pth").write_text(sysconfig.get_path("purelib"))  # what it depends on; its own files come first
    for name in ("stages", "plugins"):
        (site / f"{name}.py").write_text("raise SystemError('not ours')")
    return site


def start(site: Path, *words: object) -> subprocess.CompletedProcess[str]:
    """Start a program of the environment, in an empty folder."""
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [site.parents[2] / "bin" / str(words[0]), *map(str, words[1:])], env=env, capture_output=True, text=True
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return done


def test_an_installed_wheel_gives_tasks_and_policies_without_snakemake(site: Path, run: Path) -> None:
    done = start(site, "python", "-c", USE, run / "results")
    assert Path(done.stdout.splitlines()[-1]) == site / "roomkin/stages"


def test_an_installed_wheel_plans_its_demo_and_tells_its_commands(site: Path) -> None:
    home = site / "roomkin"
    demo = ("--snakefile", home / "Snakefile", "--configfile", home / "demo.yaml")
    planned = start(site, "python", "-m", "snakemake", "-n", "-p", *demo, "--", "pages").stdout
    assert "python -m roomkin.stages.matching match" in planned
    assert "usage: roomkin matching match" in start(site, "roomkin", "matching", "match", "--help").stdout
