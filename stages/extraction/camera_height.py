"""Whether a camera is as high over the floor as people hold one, and things are as high as usual in this unit."""

from collections.abc import Iterable

import numpy as np

from roomkin.stages.contracts.categories import sizes_of
from roomkin.stages.contracts.category import USUAL_SPREAD
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.images import DEPTH_UNITS
from roomkin.stages.contracts.objects import SceneObject

LOWEST, HIGHEST = DoubtKind.CAMERA_HEIGHT.bounds
# What makes a camera seem higher, or lower, than it is, and by what its height is to be multiplied then.
TOO_HIGH = {"depth in feet": 0.3048, "intrinsics of half the picture's size": 0.5, "depth in decimetres": 0.1}
TOO_LOW = {"depth in centimetres, taken for millimetres": 10.0, "intrinsics of twice the picture's size": 2.0}


def doubt_height(height: float) -> str:
    """A warning about a camera's height over the floor, metres, and which mistakes make such a height; empty: none.

    Depth of 8 bits has steps of no known size: it is named wherever the camera is too low.
    """
    if LOWEST <= height <= HIGHEST:
        return ""
    causes = TOO_HIGH if height > HIGHEST else TOO_LOW
    found = [f"{name} ({height * by:.2f} m)" for name, by in causes.items() if LOWEST <= height * by <= HIGHEST]
    found += ["depth of 8 bits, whose steps are no millimetres"] if height < LOWEST else []
    why = f" if it is not, these would make it so: {', '.join(found)}" if found else ""
    return f"the camera is {height:.2f} m above the floor: is that so?{why}"


def doubt_unit(items: Iterable[SceneObject]) -> str:
    """A warning that things are too large or small by one factor, with the unit of depth that mends it; empty: none.

    It takes two things at least, of which most are unusual as they are, and all usual with the median of what would
    make each as high as its category is.
    """
    ranges = []
    for item in items:
        heights = sizes_of(item.label)[:, 2]
        if item.box is not None and len(heights):
            ranges.append(np.log([heights.min(), heights.max()]) - np.log(item.box.size[2]))
    if len(ranges) < 2:
        return ""
    factor = float(np.median(np.mean(ranges, axis=1)))
    unusual = sum(not low - USUAL_SPREAD <= 0 <= high + USUAL_SPREAD for low, high in ranges)
    fitting = sum(low - USUAL_SPREAD <= factor <= high + USUAL_SPREAD for low, high in ranges)
    if 2 * unusual <= len(ranges) or fitting < len(ranges) or abs(factor) < USUAL_SPREAD:
        return ""
    times = float(np.exp(factor))
    unit = min(DEPTH_UNITS, key=lambda one: abs(np.log(one / (1000 / times))))
    fits = f"{unit:g}" if abs(np.log(unit * times / 1000)) < USUAL_SPREAD / 2 else f"{float(f'{1000 / times:.2g}'):g}"
    much, what = (times, "small") if times > 1 else (1 / times, "large")
    told = f"{unusual} of {len(ranges)} things are {much:.1f} times too {what}"
    return f"{told}: --unit {fits} if depth was read as mm, {float(fits) / 1000:g} if as m"
