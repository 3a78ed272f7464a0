"""The shared state of the judges that render: the object at hand, ready to be fitted to, and the models read so far."""

import numpy as np

from roomkin.plugins.render_and_compare.fits import Fitter
from roomkin.plugins.render_and_compare.rendering import ColoredSolid
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.geometry.masks import MIN_PIXELS
from roomkin.stages.matching.snapshots import AbstainedError, Question

MODELS = 300  # kept in memory; chosen


class Workbench:
    """Made once per judge."""

    def __init__(self, judge: str, resolution: int) -> None:
        self.judge, self.resolution = judge, resolution
        self._folders: AssetFolders | None = None
        self._solids: dict[str, ColoredSolid] = {}
        self._object: tuple[str, Fitter] | None = None

    def fitter(self, question: Question) -> Fitter:
        """The object, made ready once.

        Raises:
            AbstainedError: too little is known of it to put anything in its place.
        """
        if self._object is None or self._object[0] != question.name:
            view, item, scene = question.view, question.item, question.scene
            if item is None or scene is None or item.box is None:
                raise AbstainedError(f"{self.judge}: extraction gives no box")
            pixels = int(view.mask.sum())
            if pixels < MIN_PIXELS:
                raise AbstainedError(f"{self.judge}: the object has {pixels} pixels, fewer than {MIN_PIXELS}")
            if view.depth is None or view.intrinsics is None or 2 * np.count_nonzero(view.depth[view.mask]) < pixels:
                raise AbstainedError(f"{self.judge}: less than half of the object has depth")
            self._object = (question.name, Fitter(view, item, scene, self.resolution))
        return self._object[1]

    def solid(self, question: Question, asset: str) -> ColoredSolid:
        """A model of the library.

        Raises:
            AbstainedError: there is only the library's index.
        """
        self._folders = self._folders or AssetFolders(question.library)
        if asset not in self._solids:
            if not (archive := self._folders.archive(asset)).is_file():
                raise AbstainedError(f"{self.judge}: there is no {archive.name} beside {question.library.name}")
            while len(self._solids) >= MODELS:
                self._solids.pop(next(iter(self._solids)))
            self._solids[asset] = ColoredSolid(self._folders[asset])
        return self._solids[asset]
