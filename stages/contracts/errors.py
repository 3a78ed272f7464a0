"""What goes wrong, in a line that says how to mend it; counts, sizes and letters in words for people."""

import os
import re
import unicodedata
from collections.abc import Collection, Iterable
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

if TYPE_CHECKING:
    import yaml

MAX_LISTED = 40  # names at most that an error lists
# What Python and libraries raise over a file's content, in words; what is of no kind here is told as damaged.
WORDS: tuple[tuple[type[Exception] | tuple[type[Exception], ...], str], ...] = (
    (UnicodeError, "it is no text in UTF-8"),
    (RecursionError, "it is nested too deep"),
    (MemoryError, "it does not fit into the memory"),
    ((LookupError, AttributeError, TypeError), "something in it is missing, or of another form"),
    (ValueError, "something in it is of another form"),
)


class InputError(Exception):
    """Input that cannot be used: what is wrong, where, and how to mend it.

    The command line prints it as one line and exits with 1; nothing is left half-written.

    Attributes:
        code: what kind of fault it is, e.g. E-DEPTH-UNIT: stays the same when the words change.
    """

    def __init__(self, where: object, what: str, fix: str = "", *, code: str) -> None:
        self.where, self.what, self.fix = map(escape_control, (str(where), what, fix))
        self.code = code
        super().__init__((f"{self.where}: " if where else "") + self.what + (f" Fix: {self.fix}" if fix else ""))


class ObjectError(InputError):
    """One object, or the model in its place, cannot be used: that object fails, and the others go on.

    A file that cannot be read is none: it would be counted against the method.
    """


def escape_control(text: str) -> str:
    """A text that a terminal shows as it is: what steers it, as names of files may, and line breaks but our own, which
    are indented, are written as escapes."""
    lines = ("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line) for line in text.split("\n  "))
    return "\n  ".join(lines)


def explain(error: Exception) -> str:
    """What stopped the reading of a file, in words for whoever made that file."""
    if isinstance(error, OSError) and error.errno:
        return os.strerror(error.errno).lower()
    return next((words for kinds, words in WORDS if isinstance(error, kinds)), "damaged, cut off, or of another format")


def suggest_nearest(name: object, names: Collection[str]) -> str:
    """The mend of a name that does not exist: the nearest that does, else all of them."""
    near = get_close_matches(str(name), names, cutoff=0.5)
    near.sort(key=lambda one: sorted(one) != sorted(str(name)))  # letters that changed places come first
    shown = [*names][:MAX_LISTED]
    more = f" and {len(names) - MAX_LISTED} more" if len(names) > MAX_LISTED else ""
    return f"did you mean '{near[0]}'?" if near else f"there are: {', '.join(shown)}{more}"


def suggest_file(path: Path | str) -> str:
    """The mend of a file that is not there: the nearest by its name that lies there; empty: there is none."""
    path, beside = Path(path), []
    with suppress(OSError, ValueError):
        beside = [each.name for each in path.parent.iterdir() if each.is_file()]
    stems = {Path(name).stem: name for name in sorted(beside, key=lambda name: (name.endswith(path.suffix), name))}
    near = get_close_matches(path.stem, stems, n=1, cutoff=0.75)
    return f"did you mean '{path.with_name(stems[near[0]])}'?" if near else ""


def file_missing(path: Path | str, fix: str = "") -> InputError:
    """The error of a file that is not there; `fix`: what helps if it is not merely misspelt."""
    mend = " Else ".join(filter(None, [suggest_file(path), fix])) or "correct the path"
    return InputError(path, "no such file.", mend, code="E-FILE-MISSING")


def count(number: int, noun: str, plural: str = "") -> str:
    """'1 run', '2 runs'; `plural`: where it is not the noun with an s."""
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def describe_size(size: Iterable[float]) -> str:
    """Depth, width and height, metres, as people say them: '80 wide × 60 deep × 90 cm high'."""
    depth, width, height = (f"{100 * extent:.0f}" for extent in size)
    return f"{width} wide × {depth} deep × {height} cm high"


def plain_letters(text: str) -> str:
    """In small letters, without accents, in one Unicode form; `Łóżka` is lozka."""
    letters = unicodedata.normalize("NFKD", unicodedata.normalize("NFKC", text).casefold())
    bare = (_plain_letter(one) for one in letters if not 0x300 <= ord(one) < 0x370)
    return unicodedata.normalize("NFC", "".join(bare))


def list_plain_words(text: str) -> list[str]:
    """The words of any script in plain letters, without what is no letter: `Bürostuhl_2` is burostuhl."""
    letters = plain_letters(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text))
    return "".join(one if unicodedata.category(one)[0] in "LM" else " " for one in letters).split()


def _plain_letter(letter: str) -> str:
    """What a Latin letter without an accent looks like: l of ł, ae of æ."""
    name = unicodedata.name(letter, "")
    if letter.isascii() or not name.startswith("LATIN SMALL LETTER"):
        return letter
    return name.split(" WITH ")[0].split()[-1].lower()


def first_error(error: ValidationError) -> str:
    """The first complaint of a pydantic error as `field.path: message`, in one line."""
    detail = error.errors()[0]
    message = " ".join(detail["msg"].removeprefix("Value error, ").split())
    if not detail["loc"] and detail["type"] == "value_error":
        return message  # a check of the whole file names the field itself
    field = ".".join(str(part) for part in detail["loc"]) or "(top level)"
    return f"{field}: {message}"


def line_of(path: Path, error: "yaml.YAMLError") -> str:
    """The file, with the line where reading it stopped if the error knows."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    return f"{path}:{mark.line + 1}" if mark else str(path)


def fault_of(error: "yaml.YAMLError") -> str:
    """The error of a parser in one line; with where it began, as what is left open is found out later only."""
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
    began, context = getattr(error, "context_mark", None), getattr(error, "context", None)
    since = f", {context} of line {began.line + 1}" if began and context else ""
    return " ".join(f"{what}{since}".split())
