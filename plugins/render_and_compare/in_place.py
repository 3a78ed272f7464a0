"""For people: the cousins of an object rendered in its place, with what was compared."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.render_and_compare.package import GeometryConfig
from roomkin.plugins.render_and_compare.workbench import Workbench
from roomkin.stages.contracts.cousins import Cousin
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.matching.snapshots import AbstainedError, Question, SceneObjects, Snapshots


class InPlace:
    """Renders cousins of a scene's objects; `library`: library.json, its archives beside it."""

    def __init__(self, scene: SceneObjects, library: Path) -> None:
        self.scene, self.library = scene, library
        self.workbench = Workbench("draw", GeometryConfig().resolution)

    def show(self, item: SceneObject, cousin: Cousin) -> tuple[NDArray[np.uint8], str] | None:
        """The cousin as it would be seen (h, w, 3), and its terms; None where nothing can be put in the place."""
        view = self.scene.view(item)
        question = Question(view, item.label, self.library, Snapshots(()), item.id, item=item, scene=self.scene.objects)
        try:
            fitter, solid = self.workbench.fitter(question), self.workbench.solid(question, cousin.asset)
        except AbstainedError:
            return None
        (fit,) = fitter.fit(solid, [fitter.floor_yaw(cousin.orientation.yaw)])
        cover = fit.picture.cover[..., None]
        rgb = fit.picture.rgb * cover + (1 - cover)  # on white
        hidden = (fit.picture.cover > 0) & fitter.seen.find_hidden(fit.picture.depth)
        rgb = np.where(hidden[..., None], rgb / 2, rgb)
        terms = fit.terms
        caption = (
            f"outl. {terms.outline:.2f} depth {terms.depth:.2f}\n"
            f"lines {terms.lines:.2f} col. {terms.colour:.2f}\nstretch {terms.proportions:.2f}"
        )
        return (rgb * 255).round().astype(np.uint8), caption
