"""The command line of every stage: `python -m stages.<stage> <verb> --flag value ...`.

A verb is a module `stages/<stage>/<verb>.py` (`-` is `_` there; `import`, a word of Python's own, is `import_`) with a
typed function `run`; its keyword arguments are the flags. Only the chosen verb is imported, which keeps start-up cheap.
"""

import functools
import importlib
import keyword
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

T = TypeVar("T")
SEEDS = 2**53  # as in config: JSON holds no larger ones exactly


def main(stage: str, verbs: dict[str, str]) -> None:
    """Run the verb named by `sys.argv[1]`; an `InputError` or what the system refuses becomes one line, exit code 1."""
    from stages.contracts.errors import InputError
    from stages.contracts.system import line_of

    usage = f"usage: python -m stages.{stage} VERB --help\n" + "".join(
        f"  {verb:<12} {text}\n" for verb, text in verbs.items()
    )
    argv = sys.argv[1:]
    if not argv or argv[0] not in verbs:
        asked_for_help = bool(argv) and argv[0] in ("-h", "--help")
        print(usage, file=sys.stdout if asked_for_help else sys.stderr)
        sys.exit(0 if asked_for_help else 2)

    import tyro

    from stages.guard import end_with_workflow

    end_with_workflow()
    module = argv[0].replace("-", "_") + "_" * keyword.iskeyword(argv[0])
    run = with_seeds_checked(importlib.import_module(f"stages.{stage}.{module}").run)
    try:
        tyro.cli(run, args=argv[1:], prog=f"python -m stages.{stage} {argv[0]}")
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)
    except (OSError, MemoryError, RuntimeError) as error:
        line = line_of(error)
        if line is None:
            raise
        print(f"error: {line}", file=sys.stderr)
        sys.exit(1)


def with_seeds_checked(run: Callable[..., None]) -> Callable[..., None]:
    """A verb that refuses seeds that config would, too, before it does anything."""

    @functools.wraps(run)
    def checked(*args: Any, **flags: Any) -> None:
        from stages.contracts.errors import InputError

        for name, value in flags.items():
            if name.endswith("seed") and value is not None and not 0 <= value < SEEDS:
                flag = f"--{name.replace('_', '-')}"
                raise InputError(flag, f"{value} is no seed.", f"0 to {SEEDS - 1}", code="E-SEED")
        run(*args, **flags)

    return checked


def progress(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Iterate with a progress line on stderr every few seconds (readable in a log as well)."""
    from tqdm import tqdm

    bar = "{desc}: {n_fmt}/{total_fmt} [{elapsed}<{remaining}, {rate_fmt}]" + ("" if sys.stderr.isatty() else "\n")
    return iter(tqdm(items, desc=what, total=total, mininterval=5, bar_format=bar, dynamic_ncols=True))
