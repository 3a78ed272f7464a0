"""Files that pass between stages: read, written (validated, atomic, byte for byte repeatable), and their checksums.

A checksum is one small file in a tree of its own: results/.checksums/<path below results>.
"""

import codecs
import csv
import hashlib
import io
import json
import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from roomkin.stages.contracts.errors import InputError, explain, file_missing, first_error
from roomkin.stages.contracts.system import name_file_in_errors, sync, sync_names

VERSION = 1
PARTIAL = ".partial-"  # how files and folders begin that are not yet whole
BEFORE_WRITING: list[Callable[[Path], None]] = []  # called before a result gets its name; each may refuse by an error
MAX_TEXT = 200_000_000  # bytes: no text file that passes between stages comes near


class Contract(BaseModel):
    """Part of a file that passes between stages. Unknown keys are errors, and so are NaN and infinity."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Document(Contract):
    """A whole JSON file: it says which version of its contract it follows."""

    version: Literal[1] = 1


M = TypeVar("M", bound=BaseModel)


def make_partial_path(path: Path) -> Path:
    """A path in the same folder that no other writer has; the next workflow sweeps what a killed one leaves."""
    return path.with_name(f"{PARTIAL}{secrets.token_hex(4)}-{path.name}")


def ask_before_writing(path: Path) -> None:
    """Ask all `BEFORE_WRITING` whether a result may get its name."""
    for refuse in BEFORE_WRITING:
        refuse(path)


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Yield a temporary path (same folder and suffix) that replaces `path` only if the block succeeds.

    The checksum of a result is recorded.

    Raises:
        InputError: one of `BEFORE_WRITING` refuses.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = make_partial_path(path)
    try:
        with name_file_in_errors(path, temporary):
            yield temporary
            sync(temporary)
            ask_before_writing(path)
            forget(path)
            temporary.replace(path)
            sync_names(path.parent)
            record(path)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` atomically."""
    with write_atomically(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, value: BaseModel | Any) -> None:
    """Write a contract (or plain data) as JSON, atomically."""
    write_text(path, as_json(value))


def as_json(value: BaseModel | Any) -> str:
    """A contract (or plain data) as indented JSON, in a fixed order, checked as on reading."""
    model = type(value) if isinstance(value, BaseModel) else None
    if isinstance(value, BaseModel):
        value = value.model_dump(mode="json")
    text = json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    if model:
        model.model_validate_json(text, strict=True)
    return text


def refusal(model: type[BaseModel], error: ValidationError) -> str:
    """The fault of a file, as the second part of an `InputError`."""
    return f"breaks the {model.__name__} contract at {first_error(error)}."


def check_version(path: Path, text: str, fix: str) -> None:
    """Refuse a document of another version first of all: it has other fields."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return  # the model says what is wrong with it
    if isinstance(content, dict) and (content.get("version") != VERSION or content["version"] is True):
        found = json.dumps(content["version"])[:40] if "version" in content else "missing"
        what = f"is version {found}" if found != "missing" else "names no version"
        fix = fix or "make it again with this workflow"
        what += f"; this workflow reads version {VERSION} (field 'version')."
        raise InputError(path, what, fix, code="E-CONTRACT-VERSION")


def check_file(path: Path, fix: str = "") -> None:
    """Refuse what is there and is no file: a pipe would be read for ever.

    Raises:
        InputError: it is a folder, a pipe or a device.
    """
    if path.exists() and not path.is_file():
        raise InputError(path, "is no file, but a folder, a pipe or a device.", fix, code="E-FILE-UNREADABLE")


def decode_file(path: Path) -> str:
    """The text of a file in UTF-8, or in UTF-16 with its mark, as programs of Windows save it; without the mark."""
    with path.open("rb") as file:
        wide = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    return path.read_text(encoding="utf-16" if wide else "utf-8-sig")


def read_text(path: Path, fix: str = "") -> str:
    """The text of `path`, or an `InputError` that names it."""
    try:
        check_file(Path(path), fix)
        if Path(path).stat().st_size > MAX_TEXT:
            raise InputError(path, f"is larger than {MAX_TEXT // 10**6} MB.", fix, code="E-FILE-LARGE")
        return decode_file(Path(path))
    except FileNotFoundError:
        raise file_missing(path, fix) from None
    except UnicodeDecodeError:
        fix = fix or "name a text file, or save it as UTF-8"
        raise InputError(path, "is no UTF-8 text.", fix, code="E-FILE-ENCODING") from None
    except OSError as error:
        raise InputError(path, f"cannot be read ({explain(error)}).", fix, code="E-FILE-UNREADABLE") from None


def read_json(model: type[M], path: Path, fix: str = "") -> M:
    """Read and validate one contract file.

    Raises:
        InputError: the file is missing, is not JSON, or breaks its contract (file and field named).
    """
    return parse_json(model, read_text(path, fix), path, fix)


def parse_json(model: type[M], text: str, path: Path, fix: str = "") -> M:
    """The same of the text of a file `path`, wherever it was read."""
    if issubclass(model, Document):
        check_version(path, text, fix)
    try:
        return model.model_validate_json(text, strict=True)
    except ValidationError as error:
        raise InputError(path, refusal(model, error), fix, code="E-CONTRACT-BROKEN") from None


def read_lines(model: type[M], path: Path, fix: str = "") -> list[M]:
    """A file with one JSON document per line, at least one.

    Raises:
        InputError: it is missing or empty, or a line breaks the contract (file, line and field named).
    """
    rows = []
    for number, line in enumerate(read_text(path, fix).splitlines(), 1):
        try:
            rows.append(model.model_validate_json(line, strict=True))
        except ValidationError as error:
            raise InputError(f"{path}:{number}", refusal(model, error), fix, code="E-CONTRACT-BROKEN") from None
    if not rows:
        raise InputError(path, "is empty.", fix, code="E-FILE-EMPTY")
    return rows


def read_rows(model: type[M], path: Path, fix: str = "") -> list[M]:
    """A CSV table whose columns are the model's fields, at least one row; an empty cell of an optional field is None.

    Raises:
        InputError: it is missing or empty, has other columns, or a row breaks the contract (file, line, field named).
    """
    optional = {name for name, field in model.model_fields.items() if type(None) in get_args(field.annotation)}
    reader = csv.DictReader(io.StringIO(read_text(path, fix), newline=""), strict=True)
    rows: list[M] = []
    seen: dict[tuple[object, ...], int] = {}
    try:
        columns = list(reader.fieldnames or [])
        wrong = [name for name in model.model_fields if name not in columns]
        wrong = [f"lacks the column '{name}'" for name in wrong]
        wrong += [f"has the unknown column '{name}'" for name in columns if name not in model.model_fields]
        if wrong or len(set(columns)) < len(columns):
            raise InputError(path, f"{(wrong or ['has a column twice'])[0]}.", fix, code="E-TABLE-COLUMNS")
        for values in reader:
            if None in values or None in values.values():
                what = "has more or fewer cells than the header."
                raise InputError(f"{path}:{reader.line_num}", what, fix, code="E-TABLE-COLUMNS")
            cells = {name: None if name in optional and value == "" else value for name, value in values.items()}
            rows.append(model.model_validate(cells))
            key = tuple(getattr(rows[-1], name) for name in getattr(model, "once", ()))
            if key and seen.setdefault(key, reader.line_num) != reader.line_num:
                same = ", ".join(f"{name} {value}" for name, value in zip(model.once, key, strict=True))  # type: ignore[attr-defined]
                what = f"is line {seen[key]} again ({same})."
                raise InputError(f"{path}:{reader.line_num}", what, fix, code="E-TABLE-ROW-TWICE")
    except csv.Error as error:
        raise InputError(f"{path}:{reader.line_num}", f"is not CSV ({error}).", fix, code="E-FILE-UNREADABLE") from None
    except ValidationError as error:
        raise InputError(f"{path}:{reader.line_num}", refusal(model, error), fix, code="E-CONTRACT-BROKEN") from None
    if not rows:
        raise InputError(path, "has no rows.", fix, code="E-FILE-EMPTY")
    return rows


def read_options(model: type[M], text: str) -> M:
    """Parse a stage's `--options`: JSON text, a path to a JSON file, or nothing for the defaults."""
    text = text.strip() or "{}"
    source = "--options"
    if not text.startswith("{"):
        source, text = text, read_text(Path(text))
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        what, fix = first_error(error) + ".", "see config/README.md for the keys"
        raise InputError(source, what, fix, code="E-OPTIONS-INVALID") from None


RESULTS = Path("results")  # of the working directory, which is that of the workflow in its jobs
CHECKSUMS = ".checksums"


def digest_of(path: Path) -> str:
    """SHA-256 of a file, as hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def record_of(path: Path, results: Path | None = None) -> Path | None:
    """Where the checksum of a result is; None: the path is no result, or not yet one. `results`: None finds them: the
    nearest folder above it that has checksums, or is `results` of the working directory."""
    path, own = Path(os.path.normpath(path.absolute())), (results or RESULTS).absolute()
    above = (each for each in path.parents if each == own or (each / CHECKSUMS).is_dir())
    results = own if results else next(above, None)
    if results is None or any(part.startswith(".") for part in path.relative_to(results).parts):
        return None
    return results / CHECKSUMS / path.relative_to(results)


def forget(path: Path) -> None:
    """Remove the checksum of a result, or those of a folder, about to change: a kill in between leaves no wrong one."""
    found = record_of(path)
    if found and found.is_dir():
        shutil.rmtree(found)
    elif found:
        found.unlink(missing_ok=True)


def record(path: Path) -> None:
    """Write down the checksum of a finished result, or of each file of a folder; nothing for other files."""
    for file in filter(Path.is_file, path.rglob("*") if path.is_dir() else [path]):
        if found := record_of(file):
            found.parent.mkdir(parents=True, exist_ok=True)
            found.write_text(f"{digest_of(file)}\n", encoding="ascii")


def read_recorded(path: Path, results: Path | None = None) -> str | None:
    """The checksum that was recorded of a result; None: none, or none that can be read, as after a power cut."""
    found = record_of(path, results)
    try:
        text = found.read_bytes() if found and found.is_file() else b""
    except OSError:
        return None
    return text.decode().strip() if re.fullmatch(rb"[0-9a-f]{64}\n", text) else None
