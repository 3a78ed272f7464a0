"""Turn a validation error of the config into one helpful line."""

from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Every pydantic model inside a (possibly generic) annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models(argument)]


def _keys_at(model: type[BaseModel], path: tuple[int | str, ...]) -> list[str]:
    """Field names that are allowed where `path` leads to."""
    for part in path:
        field = model.model_fields.get(str(part))
        if field is None:
            continue  # a free key of a dict: stay on the dict's value model
        models = _models(field.annotation)
        if not models:
            return []
        model = models[0]
    return list(model.model_fields)


def explain(root: type[BaseModel], error: ValidationError) -> str:
    """The first error as `section.key: what is wrong`, with the nearest known key for a typo."""
    detail = error.errors()[0]
    path = detail["loc"]
    name = ".".join(str(part) for part in path)
    if detail["type"] == "extra_forbidden":
        keys = _keys_at(root, path[:-1])
        near = get_close_matches(str(path[-1]), keys, n=1, cutoff=0.5)
        hint = f"did you mean '{near[0]}'?" if near else f"known keys: {', '.join(keys)}."
        return f"{name}: unknown key; {hint}"
    if detail["type"] == "value_error":  # raised by our own checks, which name the key
        return detail["msg"].removeprefix("Value error, ")
    return f"{name}: {detail['msg']} (got {detail['input']!r})"
