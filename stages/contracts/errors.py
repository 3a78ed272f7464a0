"""The one exception that a user is meant to see."""

from collections.abc import Collection
from difflib import get_close_matches


class InputError(Exception):
    """Input that cannot be used: what is wrong, where, and how to mend it (docs/errors.md has all codes).

    The command line prints it as one line and exits with 1; nothing is left half-written.

    Attributes:
        code: what kind of fault it is, e.g. E-DEPTH-UNIT: stays the same when the words change.
    """

    def __init__(self, where: object, what: str, fix: str = "", code: str = "E-INPUT") -> None:
        self.where, self.what, self.fix, self.code = str(where), what, fix, code
        super().__init__(f"{where}: {what}" + (f" Fix: {fix}" if fix else ""))


def nearest(name: object, names: Collection[str]) -> str:
    """The mend of a name that does not exist: the nearest that does, else all of them."""
    near = get_close_matches(str(name), names, n=1, cutoff=0.5)
    return f"did you mean '{near[0]}'?" if near else f"there are: {', '.join(names)}"
