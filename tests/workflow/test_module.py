"""The workflow as a part of another one, in another folder, and as Snakemake's catalogue and snakedeploy lay it out."""

import re
import shutil
from pathlib import Path

import pytest
import yaml

from roomkin.stages.config.model import merge_mappings
from tests.workflow.workspace import MICRO, ROOT, dry_run, make, planned, snakemake

MODULE = """
configfile: "config/config.yaml"

module acdc:
    snakefile: "{snakefile}"
    config: config
    {more}

use rule * from acdc{renamed}
"""


def other(folder: Path, snakefile: Path = ROOT / "Snakefile", more: str = "", renamed: str = "") -> Path:
    """A workflow that has ours as a module, with the micro config as `config/config.yaml`."""
    default, micro = (yaml.safe_load((ROOT / name).read_text()) for name in ("config.yaml", MICRO[1]))
    (folder / "config").mkdir(parents=True)
    (folder / "config/config.yaml").write_text(yaml.safe_dump(merge_mappings(default, micro)))
    (folder / "workflow").mkdir()
    text = MODULE.format(snakefile=snakefile, more=more, renamed=renamed)
    (folder / "workflow/Snakefile").write_text(text)
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, int]:
    """All jobs of the micro run."""
    return planned(dry_run(make(tmp_path_factory.mktemp("clone")), "all", *MICRO).stdout)


def test_another_workflow_may_use_all_rules(tmp_path: Path, whole: dict[str, int]) -> None:
    done = dry_run(other(tmp_path))
    assert planned(done.stdout) == whole and len(whole) > 25, done.stdout


def test_rules_and_files_may_have_prefixes_and_jobs_run(tmp_path: Path, whole: dict[str, int]) -> None:
    folder = other(tmp_path, more='prefix: "cousins"', renamed=" as acdc_*")
    done = dry_run(folder, "acdc_all")
    assert planned(done.stdout) == {f"acdc_{name}": count for name, count in whole.items()}, done.stdout
    files = re.findall(r"(?<![\w/])(?:results|logs|benchmarks)/\S+", done.stdout)
    assert not files, "all below cousins/"
    objects = "cousins/results/extraction/room_1/objects.json"
    done = snakemake(folder, objects)
    assert done.returncode == 0 and (folder / objects).is_file(), done.stdout[-3000:]
    assert {path.name for path in folder.iterdir()} == {"config", "workflow", "cousins", ".snakemake"}


def test_another_folder_needs_no_file_of_ours(tmp_path: Path, whole: dict[str, int]) -> None:
    here = ("--snakefile", str(ROOT / "Snakefile"), "--directory", str(tmp_path))
    done = dry_run(ROOT, "all", *here, *MICRO)
    assert planned(done.stdout) == whole, done.stdout
    assert planned(dry_run(tmp_path, "all", *here).stdout)["all"] == 1, "without any config the shipped one counts"
    (tmp_path / "config.yaml").write_text("{seed: 1, sead: 2}")
    assert "sead: unknown key" in dry_run(ROOT, *here).stdout, "else that of the folder"


def test_snakedeploy_finds_what_it_copies(tmp_path: Path, whole: dict[str, int]) -> None:
    """`deploy-workflow` copies config/ and profiles/, and uses workflow/Snakefile as a module."""
    folder = other(tmp_path / "deployed", snakefile=ROOT / "workflow/Snakefile")
    jobs = planned(dry_run(folder).stdout)
    assert jobs.pop("everything") == 1 and jobs | {"all": 1} == whole
    shutil.rmtree(folder / "config")
    for name in ("config", "profiles"):
        shutil.copytree(ROOT / name, folder / name)
    assert not (folder / "config/config.yaml").is_symlink()
    assert planned(dry_run(folder).stdout)["everything"] == 1


def test_the_catalogue_finds_what_it_asks_for() -> None:
    """Its rules for workflows of standardised usage."""
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert set(usage) == {"mandatory-flags", "software-stack-deployment"}
    assert set(usage["software-stack-deployment"]) == {"conda", "apptainer", "apptainer+conda", "report"}
    words = (ROOT / "README.md").read_text().lower()
    assert "snakemake" in words and "workflow" in words
    assert (ROOT / "workflow/Snakefile").is_file() and (ROOT / "config/README.md").is_file()
    assert list((ROOT / "rules").glob("*.smk"))
