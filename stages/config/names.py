"""Names of implementations in the config: checked, and qualified so that stages can load them."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from stages.config.mistakes import Mistake
from stages.contracts.errors import InputError
from stages.contracts.section import Section
from stages.plugins import find, list_available, qualify_module

S = TypeVar("S", bound=Section)


def kind_of(section: type[Section], field: str) -> str | None:
    """Kind of implementation that a key names; None if it names none."""
    extra = section.model_fields[field].json_schema_extra
    return str(extra["kind"]) if isinstance(extra, dict) and "kind" in extra else None


def modules(section: Section, *fields: str) -> list[str]:
    """Modules of the implementations that some keys of a section name, for the digest of a job's code."""
    named = [(kind_of(type(section), field) or "", getattr(section, field)) for field in fields]
    return [
        qualify_module(kind, name) for kind, value in named for name in ([value] if isinstance(value, str) else value)
    ]


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
            elif field == "own":
                _check_own(type(section), value, packages, key)
        except InputError as error:
            if mistakes is None:
                raise
            mistakes.append(Mistake.of(error))
            default = type(section).model_fields[field].default
            changes[field] = default if value != default else next(iter(list_available(kind or "", packages)))
    found = {field: value for field, value in changes.items() if value != getattr(section, field)}
    return section.model_copy(update=found)  # what nobody set stays so


def _check_own(section: type[Section], names: Iterable[str], packages: Sequence[str], key: str) -> None:
    """Options are given for implementations that there are, of a kind that the section names."""
    kinds = {kind for field in section.model_fields if (kind := kind_of(section, field))}
    known = {name for kind in kinds for name in list_available(kind, packages)}
    for name in names:
        if name not in known:
            raise InputError(
                f"{key}.{name}",
                f"there is no '{name}'.",
                f"there are: {', '.join(sorted(known))}",
                code="E-PLUGIN-UNKNOWN",
            )
