"""Files that `import` proposes and people correct: changes by hand are kept, the rest is proposed anew."""

import hashlib
from typing import Self

from pydantic import Field

from roomkin.stages.contracts.files import Contract


class ProposedFile(Contract):
    """A file that `import` proposes; it knows whether a person changed it."""

    guess: str | None = Field(None, description="digest of what `import` wrote; what was changed by hand counts")

    def add_checksum(self) -> Self:
        """The same, as `import` writes it."""
        return self.model_copy(update={"guess": self._digest()})

    @property
    def by_hand(self) -> bool:
        """Whether it says anything that `import` has not written."""
        return self.guess != self._digest()

    def _digest(self) -> str:
        unsaid = {name for name, value in self if value == ()}  # a key that an earlier version did not know
        return hashlib.sha256(self.model_dump_json(exclude={"guess", *unsaid}).encode()).hexdigest()[:12]
