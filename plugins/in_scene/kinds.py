"""How files of this package are checked."""

from functools import partial

from roomkin.plugins.in_scene.contract import SceneDemonstrations
from roomkin.stages.contracts.files import read_json

CHECKS = {"in_scene": partial(read_json, SceneDemonstrations)}
