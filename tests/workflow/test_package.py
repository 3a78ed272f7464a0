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
print(Path(stages.__file__).parent)
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sdist, and with the wheel that was made from it."""
    folder = tmp_path_factory.mktemp("dist")
    command = [UV, "build", "--quiet", "--offline", "--no-build-isolation", "--python", sys.executable]
    subprocess.run([*command, "--out-dir", folder, ROOT], check=True)
    return folder


def names(folder: str) -> set[str]:
    """Files below a folder of packages, but tests."""
    files = {path.relative_to(ROOT) for path in (ROOT / folder).rglob("*") if path.is_file()}
    return {file.as_posix() for file in files if not {"__pycache__", "tests"} & set(file.parts)}


def test_the_wheel_has_every_file_of_roomkin_stages_and_plugins(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    inside = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    assert inside == names("roomkin") | names("stages") | names("plugins")


def test_one_version(built: Path) -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert {path.name for path in built.glob("roomkin-*")} == {
        f"roomkin-{version}-py3-none-any.whl",
        f"roomkin-{version}.tar.gz",
    }
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    released = re.findall(r"^## (\d\S+) - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert released[0] == (version, str(cited["date-released"])) and cited["version"] == version


def test_an_installed_wheel_gives_tasks_and_policies_without_snakemake(built: Path, run: Path, tmp_path: Path) -> None:
    (wheel,) = built.glob("*.whl")
    subprocess.run([UV, "venv", "--quiet", "--offline", "--python", sys.executable, tmp_path / "venv"], check=True)
    python = tmp_path / "venv/bin/python"
    subprocess.run([UV, "pip", "install", "--quiet", "--offline", "--no-deps", "--python", python, wheel], check=True)
    site = next((tmp_path / "venv/lib").glob("*/site-packages"))
    (site / "pinned.pth").write_text(sysconfig.get_path("purelib"))  # what it depends on; its own files come first
    done = subprocess.run(
        [python, "-c", USE, run / "results"],
        cwd=tmp_path,
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert Path(done.stdout.splitlines()[-1]) == site / "stages"
