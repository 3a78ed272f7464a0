"""The one exception that a user is meant to see."""


class InputError(Exception):
    """Input that cannot be used: what is wrong, where, and how to mend it (docs/errors.md has all codes).

    The command line prints it as one line and exits with 1; nothing is left half-written.

    Attributes:
        code: what kind of fault it is, e.g. E-DEPTH-UNIT: stays the same when the words change.
    """

    def __init__(self, where: object, what: str, fix: str = "", code: str = "E-INPUT") -> None:
        self.where, self.what, self.fix, self.code = str(where), what, fix, code
        super().__init__(f"{where}: {what}" + (f" Fix: {fix}" if fix else ""))
