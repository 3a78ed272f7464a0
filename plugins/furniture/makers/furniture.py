"""The maker of recipes for the core: a `roomkin.stages.articulated.resizing.Maker`."""

from roomkin.plugins.furniture.folder import make_model
from roomkin.plugins.furniture.refinishing import paint, refinish


class Maker:
    """Makes and paints our models by their recipes."""

    make_model, paint, refinish = staticmethod(make_model), staticmethod(paint), staticmethod(refinish)
