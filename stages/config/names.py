"""Names of implementations and of the user's own commands (`stages`) in the config: checked and qualified."""

from collections.abc import Sequence
from typing import Annotated, Any, TypeVar

from pydantic import BeforeValidator, Field, ValidationError

from roomkin.stages.config.mistakes import Mistake, mistakes_of, tell_package, truths
from roomkin.stages.config.packages import find_packages
from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.section import Section
from roomkin.stages.plugins import find, find_options, list_available, qualify_module

S = TypeVar("S", bound=Section)


def kind_of(section: type[Section], field: str) -> str | None:
    """Kind of implementation that a key names; None if it names none."""
    extra = section.model_fields[field].json_schema_extra
    return str(extra["kind"]) if isinstance(extra, dict) and "kind" in extra else None


def modules(section: Section, *fields: str) -> list[str]:
    """Modules of the implementations that some keys of a section name, for the digest of a job's code."""
    named = [(kind_of(type(section), field) or "", getattr(section, field)) for field in fields]
    found = [(kind, [value] if isinstance(value, str) else value) for kind, value in named]
    return [qualify_module(kind, name) for kind, names in found for name in names]


def resolve_names(section: S, packages: Sequence[str], path: str, mistakes: list[Mistake] | None = None) -> S:
    """The section with the names of a user's implementations qualified, so that a stage can import them.

    Args:
        mistakes: gets names that there is no implementation of; the default takes their place, or
            any, if it is not there.

    Raises:
        InputError: the same, if `mistakes` is not given; key and nearest name are named.
    """
    changes: dict[str, Any] = {}
    for field in type(section).model_fields:
        kind, value, key = kind_of(type(section), field), getattr(section, field), f"{path}.{field}".lstrip(".")
        try:
            if isinstance(value, Section):
                changes[field] = resolve_names(value, packages, key, mistakes)
            elif isinstance(value, dict) and all(isinstance(item, Section) for item in value.values()):
                changes[field] = {
                    name: resolve_names(item, packages, f"{key}.{name}", mistakes) for name, item in value.items()
                }
            elif kind and isinstance(value, list):
                changes[field] = [find(kind, name, packages, key) for name in value]
            elif kind:
                changes[field] = find(kind, value, packages, key)
        except InputError as error:
            if mistakes is None:
                raise
            mistakes.append(Mistake.of(error))
            default = type(section).model_fields[field].default
            changes[field] = default if value != default else next(iter(list_available(kind or "", packages)))
    if "kwargs" in type(section).model_fields:
        checked, wrong = _check_kwargs(section.model_copy(update=changes), packages, f"{path}.kwargs".lstrip("."))
        changes["kwargs"] = checked
        if wrong and mistakes is None:
            raise InputError(wrong[0].key, f"{wrong[0].what}.", wrong[0].mend, code=wrong[0].code)
        if mistakes is not None:
            mistakes += wrong
    found = {field: value for field, value in changes.items() if value != getattr(section, field)}
    return section.model_copy(update=found)  # what nobody set stays so


def _check_kwargs(section: Section, packages: Sequence[str], key: str) -> tuple[dict[str, Any], list[Mistake]]:
    """The options that a section has for implementations, and what is wrong with them.

    Of a section that names one implementation they are this one's, with the defaults of those that are not given; of
    one that names several, or a list, they are given by names of implementations.
    """
    given: dict[str, Any] = section.kwargs  # type: ignore[attr-defined]
    named = [(kind, field) for field in type(section).model_fields if (kind := kind_of(type(section), field))]
    if len(named) == 1 and isinstance(getattr(section, named[0][1]), str):
        ((kind, field),) = named
        return _check_options(find_options(kind, getattr(section, field)), given, key)
    known = {name: (kind, module) for kind, _ in named for name, module in list_available(kind, packages).items()}
    checked, mistakes = dict[str, Any](), list[Mistake]()
    for name, options in given.items():
        if name not in known:
            mend = suggest_nearest(name, known)
            mistakes.append(Mistake(f"{key}.{name}", f"there is no '{name}'", mend, "E-PLUGIN-UNKNOWN"))
            continue
        checked[name], wrong = _check_options(find_options(*known[name]), options, f"{key}.{name}")
        mistakes += wrong
    return checked, mistakes


def _check_options(model: type[Section], given: dict[str, Any], key: str) -> tuple[dict[str, Any], list[Mistake]]:
    if mistakes := truths(given, model, key):
        return {}, mistakes
    try:
        return model.model_validate(given).model_dump(mode="json"), []
    except ValidationError as error:
        return {}, [each._replace(key=each.key.rstrip(".")) for each in mistakes_of(model, error, f"{key}.")]


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
