"""Flags that the rule gives to the command of this package."""

import json
from typing import Any

from plugins.inputs.pictures import PicturesExperiment
from stages.config.model import Config
from stages.config.reads import options_of


def draw_options(config: Config, scene: str) -> str:
    """The --options of `draw` for one picture: the config, and how its camera sees."""
    assert isinstance(config.experiment, PicturesExperiment)
    photo: Any = config
    camera = {
        "field_of_view": config.experiment.inputs[scene].fov or photo.photo.field_of_view,
        "lens": photo.photo.lens,
    }
    return json.dumps(options_of(config, "single_view", "draw", {}) | camera, sort_keys=True)
