"""What may be wrong with an object of a scene and a person can mend. All else that is odd is a note."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict

from stages.contracts.files import Contract
from stages.contracts.types import Text

Cause = Literal["affordance", "camera", "place", "size", "name", "mounting"]
BRING = "choose another model on the correction page, or bring one (docs/your-models.md)"
# The most important first, and what a person can do about each.
MEND: dict[Cause, str] = {
    "affordance": BRING,
    "camera": "check the unit of depth and the intrinsics, or give one known length",
    "place": "move it on the correction page, or name and say what carries it",
    "size": "type a length that you know: its own on the correction page, or one of the picture if all are off",
    "name": f"call it otherwise; or {BRING}",
    "mounting": "say on the correction page how it is held",
}


class Doubt(Contract):
    """What may be wrong, in words; `MEND` has what helps against each cause."""

    model_config = ConfigDict(frozen=True)

    cause: Cause
    what: Text

    def __str__(self) -> str:
        return f"{self.what}: {MEND[self.cause]}"


def _as_doubt(said: Any) -> Any:
    """Scenes of earlier versions have sentences without a cause, most of them of places."""
    return {"cause": "place", "what": said} if isinstance(said, str) else said


AnyDoubt = Annotated[Doubt, BeforeValidator(_as_doubt)]


def gravest_first(doubts: list[Doubt]) -> list[Doubt]:
    """In the order of their causes, each once."""
    return sorted(dict.fromkeys(doubts), key=lambda one: list(MEND).index(one.cause))
