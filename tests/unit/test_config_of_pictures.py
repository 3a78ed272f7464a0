"""What perception reads of one picture of the user's."""

import json
from pathlib import Path

import numpy as np
from PIL import Image

from roomkin.stages.config.model import load
from roomkin.stages.config.perception import GROUNDING
from roomkin.stages.config.reads import describe_picture


def test_a_picture_has_its_own_field_of_view_and_others_propose_where_a_network_measures(tmp_path: Path) -> None:
    image = tmp_path / "kitchen.png"
    Image.fromarray(np.zeros((48, 64, 3), np.uint8)).save(image)
    for by, proposers in (("networks", [GROUNDING]), ("lines", ["ssd", "mobile_sam"])):
        inputs = {"one": {"image": str(image), "fov": 61}, "other": {"image": str(image)}}
        config = load({"experiment": {"inputs": inputs}, "perception": {"by": by, "field_of_view": 50}})
        said = {
            (command, scene): json.loads(describe_picture(config, command, scene))
            for command in ("see", "measure", "draw")
            for scene in inputs
        }
        for command in ("measure", "draw"):
            assert [said[command, scene]["field_of_view"] for scene in inputs] == [61, 50]
        assert "field_of_view" not in said["see", "one"] and said["see", "one"]["proposers"] == proposers
        assert said["draw", "one"]["proposers"] == ["ssd", "mobile_sam"]
