"""Read and write the files that pass between stages: validated, atomic, byte-for-byte repeatable."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from stages.contracts.errors import InputError


class Contract(BaseModel):
    """A file that passes between stages. Unknown keys are errors; `version` guards old files."""

    model_config = ConfigDict(extra="forbid", ser_json_inf_nan="strings")


M = TypeVar("M", bound=BaseModel)


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Yield a temporary path (same folder and suffix) that replaces `path` only if the block succeeds.

    Its name is always the same, so that what a killed process left behind is written over, not heaped up.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".partial-{path.name}")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` atomically."""
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, value: BaseModel | Any) -> None:
    """Write a contract (or plain data) as indented JSON, atomically and in a fixed order."""
    if isinstance(value, BaseModel):
        value = value.model_dump(mode="json")
    write_text(path, json.dumps(value, indent=1, ensure_ascii=False) + "\n")


def first_error(error: ValidationError) -> str:
    """The first complaint of a pydantic error as `field.path: message`."""
    detail = error.errors()[0]
    field = ".".join(str(part) for part in detail["loc"]) or "(top level)"
    return f"{field}: {detail['msg']}"


def read_text(path: Path, fix: str = "") -> str:
    """The text of `path`, or an `InputError` that names it."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(path, "no such file.", fix) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read ({error.__class__.__name__}).", fix) from None


def read_json(model: type[M], path: Path, fix: str = "") -> M:
    """Read and validate one contract file.

    Raises:
        InputError: the file is missing, is not JSON, or breaks its contract (file and field named).
    """
    try:
        return model.model_validate_json(read_text(path, fix))
    except ValidationError as error:
        raise InputError(path, f"breaks the {model.__name__} contract at {first_error(error)}.", fix) from None


def read_options(model: type[M], text: str) -> M:
    """Parse a stage's `--options`: JSON text, a path to a JSON file, or nothing for the defaults."""
    text = text.strip() or "{}"
    source = "--options"
    if not text.startswith("{"):
        source, text = text, read_text(Path(text))
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        raise InputError(source, first_error(error) + ".", "see config/README.md for the keys") from None
