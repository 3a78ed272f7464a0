"""Config section `stages`: verbs of stages that are replaced by the user's own commands."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from stages.config.packages import find_packages
from stages.contracts.errors import suggest_nearest
from stages.contracts.section import Section

VERBS = {
    "assets": ("join", "part", "snapshots"),
    "extraction": ("extract",),
    "matching": ("features", "shards", "match", "distances"),
    "generation": ("generate",),
    "experiment": ("select",),
    "demonstrations": ("collect",),
    "training": ("train",),
    "evaluation": ("selection-rollout", "choose", "rollout", "merge", "score"),
    "tables": ("scenes", "policies"),
}


class VerbCommand(Section):
    """Replaces one verb of a stage by a command of yours, in any language."""

    command: str = Field(
        min_length=1,
        description="Called as `<command> --flags ...` with the flags of the verb (docs/extending.md); what it "
        "writes is checked against the contract before the workflow goes on.",
    )
    code: list[str] = Field(
        [], description="Files and folders of the command: an edit of one makes what it wrote again."
    )


def _known_verbs(value: Any) -> Any:
    """Refuse stages and verbs that do not exist, with the nearest one that does."""
    verbs = VERBS | {name: tuple(package.verbs) for name, package in find_packages().items() if package.verbs}
    for stage, commands in value.items() if isinstance(value, dict) else ():
        if stage not in verbs:
            raise ValueError(f"no stage is called '{stage}'; {suggest_nearest(stage, verbs)}")
        for verb in commands if isinstance(commands, dict) else ():
            if verb not in verbs[stage]:
                raise ValueError(f"no verb of {stage} is called '{verb}'; {suggest_nearest(verb, verbs[stage])}")
    return value


Replaced = Annotated[dict[str, dict[str, VerbCommand]], BeforeValidator(_known_verbs)]
