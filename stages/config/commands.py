"""The parameters of a rule that runs a command: defaults by the library's size, line, code, the check after it."""

import shlex
from collections.abc import Mapping
from typing import Any

from roomkin.stages.config.code import code_digest, files_digest
from roomkin.stages.config.model import Config
from roomkin.stages.config.names import ReplacementCommand
from roomkin.stages.config.packages import home_of, packages_on

LARGE = 2_000  # models: beyond, features are compressed and candidates shortlisted (docs/matching.md)
DIMENSIONS, SHORTLIST = 72, 100
PER_SHARD = 300  # models: 780 MB of features as they are


def fill_counts(config: Config, models: int) -> Config:
    """The config with numbers where it says null, for a library of so many models."""
    procedural = sum(config.assets.counts.values())
    large = models > LARGE
    assets = _fill_section(config.assets, shards=max(2, -(-procedural // PER_SHARD)))
    matching = _fill_section(config.matching, dimensions=DIMENSIONS * large, shortlist=SHORTLIST * large)
    return config.model_copy(update={"assets": assets, "matching": matching})


def _fill_section(section: Any, **numbers: int) -> Any:
    """A section with these numbers under those of their keys that are null."""
    return section.model_copy(update={key: value for key, value in numbers.items() if getattr(section, key) is None})


def replacement(config: Config, stage: str, command: str) -> ReplacementCommand | None:
    """The user's own command in the place of ours."""
    return config.stages.get(stage, {}).get(command)


def command_line(config: Config, stage: str, command: str) -> str:
    """The line that runs a command: ours, or the user's own, which ends with the workflow as ours do."""
    own = replacement(config, stage, command)
    if own is None:
        return f"python -m {home_of(stage)} {command}"
    guards = [package.guard for package in packages_on(config.packages) if package.guard]
    before = [word for guard in guards for word in ("python", "-m", guard)]
    return shlex.join([*before, "bash", "-c", own.command + ' "$@"', command])


def command_digest(config: Config, stage: str, command: str, *used: str) -> str:
    """Digest of the code behind a command and of the modules that it uses besides: an edit re-runs what uses it."""
    own = replacement(config, stage, command)
    return files_digest(own.code) if own else code_digest(f"{home_of(stage)}.{command.replace('-', '_')}", *used)


def check_line(outputs: Mapping[str, str | list[str]]) -> str:
    """The command that refuses files that break their contract, and keeps them aside; `outputs`: by contract."""
    lists = {contract: [files] if isinstance(files, str) else files for contract, files in outputs.items()}
    named = [word for contract, files in lists.items() for word in (contract, *files)]
    return shlex.join(["python", "-m", "roomkin.stages.contracts", "--refuse", *named])
