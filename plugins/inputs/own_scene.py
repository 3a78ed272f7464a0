"""The config that makes an input folder a scene of an experiment."""

from pathlib import Path
from typing import Any

import yaml

from stages.config.experiment import ExperimentConfig
from stages.config.inputs import scene_of
from stages.contracts import write_text


def write_config(folder: Path, **sections: dict[str, Any]) -> Path:
    """Write `config.yaml` into an input folder: its one scene is that folder, called as it is; no policies.

    `snakemake --configfile folder/config.yaml -- pages` then goes from it to scenes of cousins and a page about them.
    `sections`: further keys of the config that fit the folder.
    """
    scene = scene_of(folder.resolve())
    targets = dict.fromkeys(ExperimentConfig().targets)  # null: the default run's objects are not in this picture
    experiment = {"rooms": [scene], "inputs": {scene: folder.as_posix()}, "targets": targets}
    path = folder / "config.yaml"
    write_text(path, yaml.safe_dump({"experiment": experiment, **sections}, sort_keys=False))
    return path
