"""One object as it is measured: its pixels, cloud and box, before anything is known of what carries it."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stages.config.extraction import ExtractionConfig
from stages.contracts.objects import SceneObject
from stages.contracts.scenes import Annotation
from stages.contracts.types import LARGEST
from stages.extraction.clouds import MAX_POINTS, ObjectError, find_object_mask, make_object_cloud
from stages.extraction.levels import fit_box_and_levels
from stages.extraction.visibility import DepthView
from stages.geometry.boxes import UprightBox, round_off_box, surface_points
from stages.geometry.masks import pixel_bounds


@dataclass(frozen=True)
class MeasuredObject:
    """An object and what the input states of it; if it did not fail its pixels (H, W), cloud (N, 3) and box, floor
    frame, and the heights at which it may carry others."""

    object: SceneObject
    stated: Annotation
    mask: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    cloud: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    box: UprightBox | None = None
    heights: tuple[float, ...] = ()

    def fail(self, reason: str) -> "MeasuredObject":
        """The object, failed."""
        update = {"status": "failed", "reason": reason, "points": 0}
        return MeasuredObject(self.object.model_copy(update=update), self.stated)


def measure_object(
    name: str,
    item: Annotation,
    whole: NDArray[np.bool_],
    view: DepthView,
    options: ExtractionConfig,
    rng: np.random.Generator,
) -> MeasuredObject:
    """The pixels inside the crop, cloud and box of the object `name`; a box that the input states is kept.

    Args:
        whole: its pixels (H, W).
        rng: chooses which points of a large cloud are left out.
    """
    is_whole = item.box is not None and not item.guessed
    other = {"box", "guessed", "mounting", "proposals", "probabilities"}
    known = SceneObject(id=name, whole=is_whole, names=item.names, **item.model_dump(exclude=other))
    share, heights = None, tuple[float, ...]()
    try:
        mask = find_object_mask(whole, options.crop, item.box is not None)
        if item.box is not None:
            box = UprightBox(item.box.center, item.box.size, item.box.yaw)
            cloud = surface_points(box, MAX_POINTS)
            cloud = cloud if item.front is not None else round_off_box(cloud, box)
        else:
            share = round(float((view.depth[mask] > 0).mean()), 3)
            cloud = make_object_cloud(mask, view, options, rng)
            box, heights = fit_box_and_levels(item.label, cloud, mask, view, options.trim)
        extent = float(np.max(box.size))
        if extent > LARGEST:
            raise ObjectError(f"{extent:.0f} m large: its depth cannot be right")
    except ObjectError as failure:
        return MeasuredObject(known, item).fail(str(failure))
    seen = {"pixels": pixel_bounds(mask), "points": len(cloud), "depth_known": share}
    return MeasuredObject(known.model_copy(update=seen), item, mask, cloud, box, heights or (box.top,))
