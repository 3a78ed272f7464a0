"""The command line of every stage and package: `python -m stages.<stage> <verb> --flag value ...`.

A verb is a module `<verb>.py` of the package (`-` is `_` there; `import`, a word of Python's own, is `import_`) with a
typed function `run`; its keyword arguments are the flags. Only the chosen verb is imported, which keeps start-up cheap.
"""

import functools
import importlib
import keyword
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from stages.contracts.section import SEEDS

T = TypeVar("T")
SECONDS = 5.0  # from one line of progress to the next


def main(package: str, verbs: dict[str, str]) -> None:
    """Run the verb that `sys.argv[1]` names; an `InputError` or what the system refuses becomes a line, exit code 1."""
    from stages.contracts.errors import InputError, suggest_nearest
    from stages.contracts.system import line_of, start_job

    usage = f"usage: python -m {package} VERB --help\n" + "".join(
        f"  {verb:<12} {text}\n" for verb, text in verbs.items()
    )
    argv = sys.argv[1:]
    if not argv or argv[0] not in verbs:
        asked_for_help = bool(argv) and argv[0] in ("-h", "--help")
        if argv and not asked_for_help:
            print(f"error: {package} has no verb '{argv[0]}'. Fix: {suggest_nearest(argv[0], verbs)}", file=sys.stderr)
        print(usage, file=sys.stdout if asked_for_help else sys.stderr)
        sys.exit(0 if asked_for_help else 2)

    import tyro

    start_job()
    run = with_seeds_checked(importlib.import_module(f"{package}.{find_module(argv[0])}").run)
    try:
        tyro.cli(run, args=argv[1:], prog=f"python -m {package} {argv[0]}")
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)
    except (OSError, MemoryError, RuntimeError) as error:
        line = line_of(error)
        if line is None:
            raise
        print(f"error: {line}", file=sys.stderr)
        sys.exit(1)


def find_module(verb: str) -> str:
    """The module of a verb in its package."""
    return verb.replace("-", "_") + "_" * keyword.iskeyword(verb)


def with_seeds_checked(run: Callable[..., None]) -> Callable[..., None]:
    """A verb that refuses seeds that config would, too, before it does anything."""

    @functools.wraps(run)
    def run_checked(*args: Any, **flags: Any) -> None:
        from stages.contracts.errors import InputError

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
