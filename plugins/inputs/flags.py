"""Flags that rules give to the commands of this package."""

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plugins.inputs.pictures import Picture, PicturesExperiment
from stages.config.model import Config
from stages.config.reads import options_of


def frame_flags(frame: Picture, files: Mapping[str, Any]) -> str:
    """The flags of `from-rgbd` for a frame; `files`: where its files lie now, by their keys."""
    flags = {
        "--rgb": files.get("image"),
        "--depth": files.get("depth"),
        "--recording": files.get("recording"),
        "--masks": files.get("masks"),
        "--labels": files.get("labels"),
        "--unit": frame.unit,
        "--depth-is": None if frame.depth_is == "z" else frame.depth_is,
        "--number": None if frame.depth else frame.number,
        "--camera": files.get("camera") or frame.camera or frame.fov,
    }
    words = [word for flag, value in flags.items() if value for word in (flag, str(value))]
    matrix = ["--camera", *map(str, frame.intrinsics)] if frame.intrinsics else []
    return shlex.join([*words, *matrix])


def weight_files(config: Config) -> list[str]:
    """The weights of the networks that a picture needs, as far as they lie here."""
    photo: Any = config
    paths = [Path(folder, "model.safetensors") for folder in photo.photo.networks().values()]
    return [str(path) for path in paths if path.is_file()]


def picture_options(config: Config, scene: str) -> str:
    """The --options of `estimate` for one picture: the config, and the picture's own field of view."""
    assert isinstance(config.experiment, PicturesExperiment)
    own = config.experiment.inputs[scene].fov
    options = options_of(config, "inputs", "estimate", {}) | ({"field_of_view": own} if own else {})
    return json.dumps(options, sort_keys=True)
