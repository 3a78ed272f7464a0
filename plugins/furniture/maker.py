"""What the core asks of the maker of recipes: a `stages.articulated.resizing.Maker`."""

from plugins.furniture.folder import make_model
from plugins.furniture.refinishing import paint, refinish

__all__ = ["make_model", "paint", "refinish"]
