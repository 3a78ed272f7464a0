"""Validate a config: what an overlay removes, and every mistake as one line with its key and how to mend it."""

from collections.abc import Iterable, Iterator
from copy import deepcopy
from difflib import get_close_matches
from typing import Any, NamedTuple, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from roomkin.stages.contracts.errors import InputError, suggest_nearest
from roomkin.stages.contracts.section import UNFIT

M = TypeVar("M", bound=BaseModel)
GONE = ("dbscan_eps", "dbscan_min_points", "approach_speed")  # options of earlier versions


class Mistake(NamedTuple):
    """Key of the config, what is wrong with it, how to mend it (may be empty), and the code of its kind."""

    key: str
    what: str
    mend: str = ""
    code: str = "E-CONFIG-CLASH"  # two keys, or a key and a file, that do not fit together

    def __str__(self) -> str:
        return f"{self.key}: {self.what}." + (f" Fix: {self.mend}" if self.mend else "")

    @classmethod
    def unknown(cls, key: str, name: str, where: str, known: Iterable[str]) -> "Mistake":
        """A key names what is not in another: `where`, which has the names in `known`."""
        return cls(key, f"'{name}' is not one of {where}", f"one of {', '.join(known) or 'none'}", "E-CONFIG-UNKNOWN")

    @classmethod
    def of(cls, error: InputError, key: str = "") -> "Mistake":
        """The message of an error, of a key if it names none itself."""
        return cls(key or error.where, error.what.rstrip("."), error.fix, error.code)


def without_removed(value: Any, annotation: Any) -> Any:
    """`value` without the entries of free-key mappings that are null: so an overlay removes what the default has."""
    annotation = getattr(annotation, "__origin__", annotation) if hasattr(annotation, "__metadata__") else annotation
    if isinstance(annotation, type) and issubclass(annotation, BaseModel) and isinstance(value, dict):
        fields = {key: field.annotation for key, field in annotation.model_fields.items()}
        return {key: without_removed(item, fields.get(key)) for key, item in value.items()}
    if get_origin(annotation) is dict and get_args(annotation)[1] is not Any:
        inner = get_args(annotation)[1]
        items = value.items() if isinstance(value, dict) else ()
        kept = {key: without_removed(item, inner) for key, item in items if item is not None}
        return kept if isinstance(value, dict) or value is None else value
    return value


def validate_config(model: type[M], given: dict[str, Any]) -> tuple[M, list[Mistake]]:
    """The config and its mistakes; where there is one, the config has its default instead."""
    mistakes = truths(given, model)
    given = deepcopy(given)
    for mistake in mistakes:
        _drop(given, tuple(mistake.key.split(".")))
    while True:
        try:
            return model.model_validate(given), mistakes
        except ValidationError as error:
            mistakes += mistakes_of(model, error)
            for detail in error.errors():
                _drop(given, detail["loc"])


def truths(given: Any, annotation: Any, key: str = "") -> list[Mistake]:
    """Keys whose number is true or false, which YAML makes of yes, no, on and off, and Python takes for 1 and 0."""
    if isinstance(given, dict):
        models = _models(annotation)
        fields = models[0].model_fields if models and get_origin(annotation) is not dict else {}
        inner = get_args(annotation)[1] if get_origin(annotation) is dict else None
        items = [(name, item, fields[name].annotation if name in fields else inner) for name, item in given.items()]
        return [each for name, item, kind in items for each in truths(item, kind, f"{key}.{name}".lstrip("."))]
    if isinstance(given, list):
        return [each for item in given for each in truths(item, annotation, key)][:1]
    kinds = list(_kinds(annotation)) if isinstance(given, bool) else [bool]
    wrong = (int in kinds or float in kinds) and bool not in kinds
    what = f"is {given} (YAML's yes and no, too), not a number"
    return [Mistake(key, what, code="E-CONFIG-VALUE")] if wrong else []


def _kinds(annotation: Any) -> Iterator[Any]:
    """All types inside an annotation."""
    yield annotation
    for argument in get_args(annotation):
        yield from _kinds(argument)


def mistakes_of(root: type[BaseModel], error: ValidationError, prefix: str = "") -> list[Mistake]:
    """All mistakes that a validation found; a typo comes with the nearest key that exists."""
    found = []
    for detail in error.errors():
        path, text = detail["loc"], detail["msg"].removeprefix("Value error, ")
        what, mend, code = text, "", "E-CONFIG-VALUE"
        if detail["type"] == "extra_forbidden":
            what, code = "unknown key", "E-CONFIG-KEY"
            moved = tell_section(str(path[0]), detail["input"]) if len(path) == 1 else ""
            gone = "leave it out: it is no option any more" if path[-1] in GONE else ""
            mend = moved or gone or _find_meant_key(str(path[-1]), _model_at(root, path[:-1]), root)
        elif detail["type"] == UNFIT:
            mend = detail["ctx"]["mend"]
        elif detail["type"] != "value_error":
            what, mend = f"{text} (got {detail['input']!r})", _how_to_write(detail["type"], detail["input"], path)
        found.append(Mistake(prefix + ".".join(map(str, path)), what, mend, code))
    return found


def _how_to_write(kind: str, given: Any, path: tuple[Any, ...]) -> str:
    """How a value of another type is written."""
    if kind == "string_type" and not isinstance(given, list):
        return """in quotes, as "0012"; behind --config as ./NAME, or ' "NAME" ' with the blanks: else YAML reads it"""
    if kind == "list_type" and not isinstance(given, dict):
        first = f" or {list(range(given))}" if path[-1] == "seeds" and type(given) is int and 1 < given < 10 else ""
        return f"write {[given]}{first}"
    return "docs/config.md says what is allowed"


def _find_meant_key(name: str, model: type[BaseModel], root: type[BaseModel]) -> str:
    """Which key was meant: the nearest by its letters, one elsewhere, else any."""
    if not model.model_fields:
        return "leave it out: no options are read here"
    elsewhere = list(_places(name, root))
    if get_close_matches(name, model.model_fields, n=1, cutoff=0.6) or not 0 < len(elsewhere) <= 3:
        return suggest_nearest(name, model.model_fields)
    return f"do you mean {' or '.join(elsewhere)}?"


def _places(name: str, model: type[BaseModel], path: str = "") -> Iterator[str]:
    """Where a key of this name is, below a section; * stands for a name that is free."""
    for field, found in model.model_fields.items():
        if field == name:
            yield f"{path}{field}"
        free = "*." if get_origin(found.annotation) is dict else ""
        for inner in _models(found.annotation):
            yield from _places(name, inner, f"{path}{field}.{free}")


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Every pydantic model inside a (possibly generic) annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models(argument)]


def _model_at(model: type[BaseModel], path: tuple[int | str, ...]) -> type[BaseModel]:
    """The section that `path` leads to."""
    for part in path:
        field = model.model_fields.get(str(part))
        if field is not None:  # else a free key of a dict: stay on the dict's value model
            model = _models(field.annotation)[0]
    return model


def _drop(given: Any, path: tuple[int | str, ...]) -> None:
    """Take out what a mistake is about: the innermost entry of a mapping that its path leads to."""
    last, key = given, path[0]
    for part in path:
        if not isinstance(given, dict) or part not in given:
            break
        last, key, given = given, part, given[part]
    last.pop(key, None)


PERCEPTION = "perception"
SECTIONS = {"photo": PERCEPTION, "eyes": PERCEPTION, "single_view": PERCEPTION}  # their keys are called the same there
PACKAGES = {
    **dict.fromkeys(("inputs", "eyes", "names", "single_view"), "it is stage perception now, which is always there"),
    "look": "it is part of the package pictures now",
}


def tell_package(name: str, otherwise: str) -> str:
    """What took the place of a package, else what is said otherwise."""
    return PACKAGES.get(name, otherwise)


def tell_section(name: str, given: object) -> str:
    """What to write in the place of a section; empty: it is where it was."""
    if name not in SECTIONS:
        return ""
    keys = given if isinstance(given, dict) else [""]
    return "write " + ", ".join(f"{SECTIONS[name]}.{key}".rstrip(".") for key in keys)
