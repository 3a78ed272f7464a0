"""Variants of matching whose published weights are not here: a run goes on without them."""

from typing import TYPE_CHECKING, Any

from roomkin.stages.config.weights import DINOV2, FOLDER

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


def list_unfetched(config: "Config") -> list[str]:
    """The variants that want DINOv2 as it is fetched, if that is not here; none, if there are no others."""
    if (FOLDER / DINOV2.name).is_file():
        return []
    options = {name: config.matching_of(name) for name in config.experiment.variants}
    wanting = [name for name, one in options.items() if one.weights().get("dinov2.path") == ""]
    return wanting if len(wanting) < len(options) else []


def leave_out(config: "Config", names: list[str]) -> "Config":
    """The config without some variants."""
    experiment = config.experiment
    protocols = {
        name: one.model_copy(update={"variants": one.variants and [each for each in one.variants if each not in names]})
        for name, one in experiment.protocols.items()
    }
    left = {name: one for name, one in experiment.variants.items() if name not in names}
    policy_variant = experiment.policy_variant
    if policy_variant in names and not experiment.targets:  # with targets it is a mistake that policies lack theirs
        policy_variant = next(iter(left))
    changes = {
        "variants": left,
        "policy_variant": policy_variant,
        "placements": {name: one for name, one in experiment.placements.items() if name not in names},
        "protocols": {name: one for name, one in protocols.items() if one.variants != []},
    }
    return config.model_copy(update={"experiment": experiment.model_copy(update=changes)})


def tell_left_out(given: dict[str, Any], config: "Config") -> str:
    """A line about the variants of a merged config that were left out of it; empty: none were."""
    named = [name for name, one in given["experiment"]["variants"].items() if one is not None]
    gone = [name for name in named if name not in config.experiment.variants]
    if config.image or not gone or (FOLDER / DINOV2.name).is_file():
        return ""
    return f"no weights of DINOv2 (make weights): without variant {', '.join(gone)}"
