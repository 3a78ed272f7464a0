"""Config section `stages`: commands of stages that are replaced by the user's own."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from roomkin.stages.config.mistakes import tell_package
from roomkin.stages.config.packages import find_packages
from roomkin.stages.contracts.errors import suggest_nearest
from roomkin.stages.contracts.section import Section

COMMANDS = {
    "assets": ("join", "part", "snapshots"),
    "perception": ("from-rgbd", "measure", "see", "draw", "fetch"),
    "extraction": ("extract",),
    "matching": ("features", "shards", "match", "distances"),
    "generation": ("generate",),
    "experiment": ("select",),
    "demonstrations": ("collect",),
    "training": ("train",),
    "evaluation": ("selection-rollout", "choose", "rollout", "merge", "score"),
    "tables": ("scenes", "policies"),
}


class ReplacementCommand(Section):
    """Replaces one command of a stage by a command of yours, in any language."""

    command: str = Field(
        min_length=1,
        description="Called as `<command> --flags ...` with the flags of the command (docs/extending.md); what it "
        "writes is checked against the contract before the workflow goes on.",
    )
    code: list[str] = Field(
        [], description="Files and folders of the command: an edit of one makes what it wrote again."
    )


def _known_commands(value: Any) -> Any:
    """Refuse stages and commands that do not exist, with the nearest one that does."""
    known = COMMANDS | {name: tuple(package.commands) for name, package in find_packages().items() if package.commands}
    for stage, commands in value.items() if isinstance(value, dict) else ():
        if stage not in known:
            raise ValueError(f"no stage is called '{stage}'; {tell_package(stage, suggest_nearest(stage, known))}")
        for command in commands if isinstance(commands, dict) else ():
            if command not in known[stage]:
                mend = suggest_nearest(command, known[stage])
                raise ValueError(f"no command of {stage} is called '{command}'; {mend}")
    return value


Replaced = Annotated[dict[str, dict[str, ReplacementCommand]], BeforeValidator(_known_commands)]
