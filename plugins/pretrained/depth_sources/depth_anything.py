"""Source of depth `depth_anything`: Depth-Anything V2, metric (weights: `roomkin perception fetch --networks`)."""

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.config.perception import MeasureOptions


def measure_depth(rgb: NDArray[np.uint8], options: MeasureOptions, device: str) -> NDArray[np.float32]:
    """Depth (H, W) in metres of a picture (H, W, 3).

    Raises:
        InputError: the weights are missing, broken, or of another kind.
    """
    from roomkin.plugins.pretrained.networks import depth_of

    return depth_of(rgb, options, device)
