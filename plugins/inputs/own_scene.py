"""The config that makes an input folder a scene of an experiment."""

import shlex
from pathlib import Path
from typing import Any

import yaml

import stages
from stages.config.experiment import ExperimentConfig
from stages.config.inputs import scene_of_folder
from stages.contracts import write_text


def is_clone(folder: Path = Path()) -> bool:
    """Whether Snakemake finds the workflow in a folder, by default where this process runs."""
    return (folder / "Snakefile").is_file() or (folder / "workflow/Snakefile").is_file()


def to_run(words: str) -> str:
    """A Snakemake command line that works from here: the workflow runs only in its clone."""
    if is_clone():
        return f"snakemake {words}"
    home = Path(stages.__file__).resolve().parents[1]
    return f"cd {shlex.quote(str(home)) if is_clone(home) else 'CLONE'} && snakemake {words}"


def write_config(folder: Path, **sections: dict[str, Any]) -> Path:
    """Write `config.yaml` into an input folder: a config with that folder as its only scene, and no policies.

    `snakemake --configfile folder/config.yaml -- pages` then goes from it to scenes of cousins and a page about them.
    `sections`: further keys of the config that fit the folder.
    """
    scene = scene_of_folder(folder)
    targets = dict.fromkeys(ExperimentConfig().targets)  # null: the default run's objects are not in this picture
    experiment = {"rooms": [scene], "inputs": {scene: folder.as_posix()}, "targets": targets}
    path = folder / "config.yaml"
    write_text(path, yaml.safe_dump({"experiment": experiment, **sections}, sort_keys=False))
    return path
