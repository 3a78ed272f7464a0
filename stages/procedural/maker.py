"""What the core asks of the maker of recipes: a `stages.articulated.resizing.Maker`."""

from stages.procedural.folder import make_model
from stages.procedural.refinishing import refinish

__all__ = ["make_model", "refinish"]
