"""Validate a config: what an overlay removes, and every mistake as one line with its key and how to mend it."""

import re
from collections.abc import Iterable, Iterator
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_args, get_origin

import yaml
from pydantic import BaseModel, ValidationError

from stages.contracts.errors import InputError, suggest_nearest

M = TypeVar("M", bound=BaseModel)

# Keys of older versions that configs may still have, and what to do instead. Those that are fixed now say so.
GONE = {
    "articulated_only": "leave it out: articulated objects get articulated cousins",
    "aspect_prior": "sizes: fitted, where it was native; sizes: measured, where it was off",
    "assets_of": "leave it out: every policy of `experiment.policies` opens every target",
    "batch": "leave it out: pictures are encoded one by one",
    "coverage": "leave it out: a patch counts if the mask covers half of it",
    "download": "name a folder with config.json and model.safetensors",
    "encoder": "python -m plugins.patchnet trains the encoder, --help has its options",
    "film_every": "leave it out: the first success and the first failure are filmed",
    "finger_points": "leave it out: an eighth of `points`",
    "geometry": "the section `geometry`, on the top level",
    "implementation": "source: folder",
    "learning": "image: a name with {family} and {tag} in it",
    "mirror": "leave it out",
    "patchnet": "kwargs: {patchnet: {...}}, with plugins: [plugins.patchnet]",
    "preview_width": "leave it out: 640 pixels",
    "report": "image: a name with {family} and {tag} in it",
    "rerender": "leave it out",
    "refinement": "snap_articulated: 0 and snap_other: 0, where it was off; else leave it out",
    "resolve_collisions": "leave it out: overlapping stacks are pushed apart",
    "revision": "leave it out: weights.lock.json pins what `fetch` downloads",
    "scene": "room: room_3",
    "seen_through": "leave it out: it is 0.35",
    "sha256": "leave it out: weights.lock.json pins what `fetch` downloads",
    "simulation": "image: a name with {family} and {tag} in it",
    "tasks": "targets: {door: {room: room_3, object: hanging_cabinet_1}} for what is opened, policies: {lite: {}, "
    "lite_handle: {}} for the runs that open it; rows with `assets_of` are policies now (docs/train.md)",
    "training_threads": "snakemake --set-threads train=2",
    "vlm": "the section `vlm`, on the top level, for matching and photo",
}


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
        """What an error says, of a key if it names none itself."""
        return cls(key or error.where, error.what.rstrip("."), error.fix, error.code)


def check_keys(file: Path) -> None:
    """Refuse a YAML file that gives a key twice: the last would win without a word.

    Raises:
        InputError: file, line and key are named.
    """
    try:
        nodes = [yaml.compose(Path(file).read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)]
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return  # who reads it says so
    for node in nodes:
        if isinstance(node, yaml.SequenceNode):
            nodes += [each for each in node.value if each not in nodes]
        if not isinstance(node, yaml.MappingNode):
            continue
        lines: dict[str, int] = {}
        for key, value in node.value:
            name, line = str(key.value), key.start_mark.line + 1
            if name in lines and name != "<<":
                raise InputError(
                    f"{file}:{line}",
                    f"'{name}' stands in line {lines[name]}, too.",
                    "keep one",
                    code="E-CONFIG-KEY-TWICE",
                )
            lines[name] = line
            nodes += [value] * (value not in nodes)


def without_removed(value: Any, annotation: Any) -> Any:
    """`value` without the entries of free-key mappings that are null: so an overlay removes what the default has."""
    annotation = getattr(annotation, "__origin__", annotation) if hasattr(annotation, "__metadata__") else annotation
    if isinstance(annotation, type) and issubclass(annotation, BaseModel) and isinstance(value, dict):
        fields = annotation.model_fields
        return {
            key: without_removed(item, fields[key].annotation) if key in fields else item for key, item in value.items()
        }
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
    """Where a number is true or false, which YAML makes of yes, no, on and off, and Python takes for 1 and 0."""
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
    return list(_mistakes_of(root, error, prefix))


def _mistakes_of(root: type[BaseModel], error: ValidationError, prefix: str) -> Iterator[Mistake]:
    for detail in error.errors():
        path = detail["loc"]
        key = prefix + ".".join(str(part) for part in path)
        text = detail["msg"].removeprefix("Value error, ")
        if detail["type"] == "extra_forbidden":
            yield _describe_unknown_key(key, str(path[-1]), _model_at(root, path[:-1]), root)
        elif detail["type"] == "value_error":
            yield Mistake(key, text, code="E-CONFIG-VALUE")
        else:
            mend = "docs/config.md says what is allowed"
            yield Mistake(key, f"{text} (got {detail['input']!r})", mend, "E-CONFIG-VALUE")


def _describe_unknown_key(key: str, name: str, model: type[BaseModel], root: type[BaseModel]) -> Mistake:
    """A key that a section does not have: of an older config, or a typo."""
    code = "E-CONFIG-KEY"
    if name in model.__class_vars__:
        return Mistake(key, f"is no option: it is {getattr(model, name)}", "leave it out", code)
    if name in GONE:
        return Mistake(key, "is no option", GONE[name], code)
    if not model.model_fields:
        return Mistake(key, "unknown key", "leave it out: no options are read here", code)
    return Mistake(key, "unknown key", _find_meant_key(name, model, root), code)


def _find_meant_key(name: str, model: type[BaseModel], root: type[BaseModel]) -> str:
    """Which key was meant: the nearest by its letters, one elsewhere, one whose meaning names the word, else any."""
    if get_close_matches(name, model.model_fields, n=1, cutoff=0.6):
        return suggest_nearest(name, model.model_fields)
    if 0 < len(elsewhere := list(_places(name, root))) <= 3:
        return f"do you mean {' or '.join(elsewhere)}?"
    word = re.compile(rf"\b{re.escape(name.lower().rstrip('s'))}s?\b", re.IGNORECASE)
    about = {field: f"{found.description} {found.json_schema_extra}" for field, found in model.model_fields.items()}
    named = [field for field, text in about.items() if word.search(text)]
    return f"do you mean {' or '.join(named)}?" if 0 < len(named) <= 3 else suggest_nearest(name, model.model_fields)


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
