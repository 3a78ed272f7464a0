"""One object as it is measured: its pixels, cloud and box, before what carries it."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import CategoryFacts, find_category
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.extraction.clouds import (
    MAX_POINTS,
    UnusableObjectError,
    find_carrying_heights,
    find_level,
    make_object_cloud,
)
from roomkin.stages.extraction.contact import DepthView
from roomkin.stages.geometry.boxes import UprightBox, round_off_box, surface_points, with_top
from roomkin.stages.geometry.clouds import minimum_box
from roomkin.stages.geometry.frames import Array
from roomkin.stages.geometry.masks import MIN_PIXELS, Mask, central_crop, pixel_bounds, remove_specks

MAX_CUT = 0.4  # share of an object's pixels outside the crop (A.7), above which it fails; chosen


@dataclass(frozen=True)
class MeasuredObject:
    """An object, what the input states of it, and the category that its label means or is like; if it did not fail its
    pixels (H, W), cloud (N, 3) and box, floor frame, and the heights at which it may carry others."""

    object: SceneObject
    stated: Annotation
    mask: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))
    cloud: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    box: UprightBox | None = None
    heights: tuple[float, ...] = ()
    category: CategoryFacts | None = None

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
    category = find_category(item.label, known_categories(), like=True)
    share, heights = None, tuple[float, ...]()
    try:
        mask = find_object_mask(whole, options.crop, item.box is not None)
        bounds = pixel_bounds(mask)
        if item.box is not None:
            box = UprightBox(item.box.center, item.box.size, item.box.yaw)
            cloud = surface_points(box, MAX_POINTS)
            cloud = cloud if item.front is not None else round_off_box(cloud, box)
        else:
            share = round(float((view.depth[mask] > 0).mean()), 3)
            cloud = make_object_cloud(mask, view, options, rng)
            box, heights = fit_box(category, cloud, view.of(mask), view, options.trim)
        extent = float(np.max(box.size))
        if extent > LARGEST:
            raise UnusableObjectError(f"{extent:.0f} m large: its depth cannot be right")
    except UnusableObjectError as failure:
        return MeasuredObject(known, item).fail(str(failure))
    seen = {"pixels": bounds, "points": len(cloud), "depth_known": share}
    return MeasuredObject(known.model_copy(update=seen), item, mask, cloud, box, heights or (box.top,), category)


def fit_box(
    category: CategoryFacts | None, cloud: Array, whole: Array, view: DepthView, trim: float
) -> tuple[UprightBox, tuple[float, ...]]:
    """The box of a cleaned cloud (N, 3), floor frame, and the heights at which it may carry others.

    What carries on its top (a table) ends at that level. A thin top that erosion removed is restored.

    Args:
        whole: (M, 3) of all its pixels.
        trim: share of the points left out at either end of the box.
    """
    box, top = minimum_box(cloud, trim), float(np.quantile(whole[:, 2], 1 - trim))
    center = box.center
    if top > box.top + view.tolerance(center):
        box, cloud = with_top(box, top), whole
    level = find_level(cloud, box, view.distance(center))
    heights = find_carrying_heights(category, level, box.top)
    if level is not None and category is not None and category.carries == "top":
        box = with_top(box, level)
    return box, heights


def find_object_mask(whole: Mask, crop_share: float, is_known: bool) -> Mask:
    """An object's pixels (H, W) inside the crop, without specks; one whose box is known may be cut off by it.

    Raises:
        ObjectError: it has none, or too few.
    """
    if not whole.any():
        raise UnusableObjectError("not in the picture: no pixel has its mask value")
    cropped = whole & central_crop(whole.shape, crop_share)
    inside = remove_specks(cropped)
    if not is_known and cropped.sum() < (1 - MAX_CUT) * whole.sum():
        raise UnusableObjectError("cut off: too much of it is outside the central crop")
    if inside.sum() < MIN_PIXELS:
        raise UnusableObjectError(f"too small or hidden: {int(inside.sum())} pixels")
    return inside
