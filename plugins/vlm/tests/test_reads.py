"""Which verbs the section `vlm` is told to."""

import pytest

from stages.config.model import complete
from stages.config.reads import options_of

Config = complete()


@pytest.mark.parametrize(("captions", "read"), [("labels", False), ("vlm", True)])
def test_the_language_model_is_read_where_it_is_asked(captions: str, read: bool) -> None:
    config = Config.model_validate({"photo": {"captions": captions}, "vlm": {"model": "toy"}})
    assert ("toy" in repr(options_of(config, "inputs", "estimate", {}))) == read
    assert "toy" not in repr(options_of(config, "matching", "match", {"variant": "b"}))
    judged = Config.model_validate({"matching": {"model_selection": "vlm"}, "vlm": {"model": "toy"}})
    assert "toy" in repr(options_of(judged, "matching", "match", {"variant": "b"}))
    other = {"variants": {"b": {"vlm": {"model": "other"}}}}
    judged = Config.model_validate({"matching": {"model_selection": "vlm"}, "experiment": other})
    assert options_of(judged, "matching", "match", {"variant": "b"})["vlm"]["model"] == "other"
