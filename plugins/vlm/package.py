"""The package as the core knows it."""

from typing import Any

from pydantic import Field

from roomkin.plugins.vlm.config import VlmConfig
from roomkin.stages.config.packages import Package


def list_models_asked(config: Any) -> list[VlmConfig]:
    """The language models that variants of matching ask, and that which captions the user's pictures."""
    options = map(config.matching_of, config.experiment.variants)
    asked = [each.vlm for each in options if "vlm" not in each.list_unread()]
    captions = config.perception.captions == "vlm" and {*config.experiment.views} & {*config.experiment.rooms}
    return [*asked, config.vlm] if captions else asked


def keys(config: Any) -> list[str] | None:
    """The variables of their keys; None: nothing is asked."""
    asked = [model.key_env for model in list_models_asked(config) if model.mode == "record"]
    return asked or None


PACKAGE = Package(
    section="vlm",
    judges=True,
    sections={
        "vlm": (
            VlmConfig,
            Field(
                VlmConfig(),
                description="The language model that sees, for the judge `vlm` and for `perception.captions: vlm` "
                "(docs/vlm.md).",
            ),
        )
    },
    outside=lambda config: [model.ledger for model in list_models_asked(config)],
    keys=keys,
)
