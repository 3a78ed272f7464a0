"""The one exception that a user is meant to see."""


class InputError(Exception):
    """Input that cannot be used: what is wrong, where, and how to mend it.

    The command line prints it as one line and exits with 1; nothing is left half-written.
    """

    def __init__(self, where: object, what: str, fix: str = "") -> None:
        self.where, self.what, self.fix = str(where), what, fix
        super().__init__(f"{where}: {what}" + (f" Fix: {fix}" if fix else ""))
