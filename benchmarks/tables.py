"""Tables in Markdown, printed row by row as they are measured."""

from collections.abc import Iterable
from typing import Any


def table(heading: list[str], rows: Iterable[list[Any]]) -> None:
    """Print a table."""
    print("\n| " + " | ".join(heading) + " |\n|" + "---|" * len(heading), flush=True)
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
