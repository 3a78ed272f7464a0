"""What a person sees in a picture on the page that corrects it."""

from pydantic import Field

from stages.contracts.corrections import Correction
from stages.contracts.files import Contract
from stages.contracts.types import Id


class Thing(Correction):
    """An object, the floor or a wall as the page shows it, with every value and not only the corrected ones."""

    id: Id


class Drawing(Contract):
    """All that is in a picture, as a person sees it."""

    objects: list[Thing] = Field([], max_length=1000)


def name_drawn(mask: int) -> str:
    """The id of a thing that the folder's annotations do not name."""
    return f"drawn_{mask}"
