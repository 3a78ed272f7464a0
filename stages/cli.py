"""The command line of every stage and package: `roomkin <stage> <command> --flag value ...`.

A command is a module `<command>.py` of the package (`-` is `_` there; `import`, a keyword of Python, is `import_`) with
a typed function `run`; its keyword arguments are the flags. Only the chosen one is imported: start-up stays cheap.
"""

import ast
import functools
import importlib
import importlib.util
import keyword
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from roomkin.stages.contracts.section import SEEDS

T = TypeVar("T")
WRITTEN = ("out", "figures")  # arguments of commands, which make what they name
SECONDS = 5.0  # from one line of progress to the next


def main(package: str, commands: dict[str, str], more: str = "", also: Iterable[str] = ()) -> None:
    """Run the command in `sys.argv[1]`; `InputError`s and what the system refuses become a line and exit code 1.

    Args:
        package: where the commands are modules.
        commands: what each does, by its name.
        more: what --help says below them.
        also: words beside the commands that a misspelt one may have meant.
    """
    from roomkin.stages.contracts.errors import InputError, file_missing, suggest_nearest
    from roomkin.stages.contracts.system import line_of, start_job

    program = " ".join(dict.fromkeys(["roomkin", package.rpartition(".")[2]]))
    lines = (f"  {command:<12} {text}\n" for command, text in commands.items())
    usage = f"usage: {program} COMMAND --help\n{''.join(lines)}{more}"
    argv = sys.argv[1:]
    if not argv or argv[0] in ("-h", "--help"):
        print(usage, file=sys.stdout if argv else sys.stderr)
        sys.exit(0 if argv else 2)
    if argv[0] not in commands:
        fix = suggest_nearest(argv[0], [*commands, *also])
        print(f"error: {program} has no command '{argv[0]}'. Fix: {fix}", file=sys.stderr)
        sys.exit(2)

    if fault := find_wrong_flag(f"{package}.{find_module(argv[0])}", argv[1:]):
        print(f"error: {program} {argv[0]}: {fault}", file=sys.stderr)
        sys.exit(2)
    if missing := find_missing_path(f"{package}.{find_module(argv[0])}", argv[1:]):
        error = file_missing(missing)
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)
    import tyro

    start_job()
    run = with_seeds_checked(importlib.import_module(f"{package}.{find_module(argv[0])}").run)
    try:
        tyro.cli(run, args=argv[1:], prog=f"{program} {argv[0]}")
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)
    except (OSError, MemoryError, RuntimeError) as error:
        line = line_of(error)
        if line is None:
            raise
        print(f"error: {line}", file=sys.stderr)
        sys.exit(1)


def find_module(command: str) -> str:
    """The module of a command in its package."""
    return command.replace("-", "_") + "_" * keyword.iskeyword(command)


def find_wrong_flag(module: str, given: list[str]) -> str:
    """A flag that a command does not have, or one that it lacks; "" if there is none, or help is wanted."""
    from roomkin.stages.contracts.errors import suggest_nearest

    flags = list_flags(module)
    if not flags or {"-h", "--help"}.intersection(given):
        return ""
    known = flags.keys() | {flag.replace("--", "--no-", 1) for flag in flags}
    words = [word.partition("=")[0].replace("_", "-") for word in given if word.startswith("--")]
    if strange := [word for word in words if word not in known]:
        return f"there is no {strange[0]}. Fix: {suggest_nearest(strange[0], flags)}"
    lacking = [flag for flag, needed in flags.items() if needed and flag not in words]
    return f"{', '.join(lacking)} not given. Fix: --help says what they are" if lacking else ""


def list_flags(module: str) -> dict[str, bool]:
    """The flags of a command, each with whether it must be given; none, where others than keywords are.

    By the text of the module, as what it imports may take seconds.
    """
    run = _read_arguments(module)
    if run is None or run.args:
        return {}
    arguments = zip(run.kwonlyargs, run.kw_defaults, strict=True)
    return {f"--{argument.arg.replace('_', '-')}": default is None for argument, default in arguments}


def find_missing_path(module: str, given: list[str]) -> str:
    """What a command is to read and is not there, by the text of its module; "" if nothing, or help is wanted.

    It reads its paths that have no default or `None`, but those of `WRITTEN`; of lists that may be empty it says itself
    what it misses.
    """
    run = _read_arguments(module)
    if run is None or run.args or {"-h", "--help"}.intersection(given):
        return ""
    flags = {f"--{one.arg.replace('_', '-')}": one for one in run.kwonlyargs}
    picture = next((one for one in run.posonlyargs if _kind(one) == "Path"), None)  # Path | None: or a scene's name
    defaults = zip(run.kwonlyargs, run.kw_defaults, strict=True)
    read = [picture, *(one for one, default in defaults if default is None or ast.unparse(default) == "None")]
    one = picture
    for word in given:
        flag, is_pair, value = word.partition("=") if word.startswith("--") else ("", "", word)
        if flag:
            one = flags.get(flag.replace("_", "-"))
            if not is_pair:
                continue
        if one and one in read and "Path" in _kind(one) and one.arg not in WRITTEN and not _is_there(value):
            return value
        if not _kind(one).startswith(("tuple", "list")):
            one = picture
    return ""


def _kind(argument: ast.arg | None) -> str:
    return ast.unparse(argument.annotation) if argument and argument.annotation else ""


def _read_arguments(module: str) -> ast.arguments | None:
    """Those of the function `run` of a module."""
    spec = importlib.util.find_spec(module)
    text = Path(spec.origin).read_text(encoding="utf-8") if spec and spec.origin else ""
    runs = (each.args for each in ast.parse(text).body if isinstance(each, ast.FunctionDef) and each.name == "run")
    return next(runs, None)


def _is_there(path: str) -> bool:
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError:
        pass  # whoever reads it says why that cannot be
    return True


def with_seeds_checked(run: Callable[..., None]) -> Callable[..., None]:
    """A command that refuses seeds that config would, too, before it does anything."""

    @functools.wraps(run)
    def run_checked(*args: Any, **flags: Any) -> None:
        from roomkin.stages.contracts.errors import InputError

        for name, value in flags.items():
            if name.endswith("seed") and value is not None and not 0 <= value < SEEDS:
                flag = f"--{name.replace('_', '-')}"
                raise InputError(flag, f"{value} is no seed.", f"0 to {SEEDS - 1}", code="E-SEED")
        run(*args, **flags)

    return run_checked


def progress(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Iterate, with a line on stderr every five seconds that says how far it is; what takes less time says nothing."""
    from tqdm import tqdm

    started, due = time.monotonic(), pacer()
    for count, item in enumerate(items, 1):
        yield item
        if due():
            bar, seconds = "{desc}: {n_fmt}/{total_fmt} [{elapsed}<{remaining}, {rate_fmt}]", time.monotonic() - started
            print(tqdm.format_meter(count, total, seconds, prefix=what, bar_format=bar), file=sys.stderr)


def pacer() -> Callable[[], bool]:
    """A question that is answered with yes once in `SECONDS`, first when so many have gone by."""
    last = [time.monotonic()]

    def is_due() -> bool:
        if (now := time.monotonic()) - last[0] < SECONDS:
            return False
        last[0] = now
        return True

    return is_due
