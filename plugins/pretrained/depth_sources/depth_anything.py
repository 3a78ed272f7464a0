"""Source of depth `depth_anything`: Depth-Anything V2, metric (weights: `roomkin perception fetch --networks`)."""

import cv2
import numpy as np
from numpy.typing import NDArray
from transformers import DepthAnythingForDepthEstimation

from roomkin.plugins.pretrained.networks import Picture, free_memory_after, prepare
from roomkin.plugins.pretrained.weights import load_pretrained
from roomkin.stages.config.perception import MeasureOptions
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.images import NEAREST, SKY


def measure_depth(rgb: Picture, options: MeasureOptions, device: str = "cpu") -> NDArray[np.float32]:
    """Depth (H, W) in metres of a picture (H, W, 3).

    Raises:
        InputError: the weights are missing, broken, or of another kind.
    """
    key, (height, width) = "perception.depth_anything", rgb.shape[:2]
    with free_memory_after(device):
        model = load_pretrained(DepthAnythingForDepthEstimation, options.depth_anything, key).to(device)
        if model.config.depth_estimation_type != "metric":
            what = f"'{options.depth_anything}' gives relative depth, not metres."
            raise InputError(key, what, "metric weights are asked for", code="E-WEIGHTS-KIND")
        patch = model.config.patch_size
        scale = 518 / min(width, height)  # pixels of the shorter side in its preprocessor
        across, down = (max(patch, round(side * scale / patch) * patch) for side in (width, height))
        found = model(prepare(rgb, across, down).to(device)).predicted_depth[0].float().cpu().numpy()
    depth = cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR)
    if not np.isfinite(depth).all():
        raise InputError(key, "gives depth that is not finite.", "other weights", code="E-WEIGHTS-KIND")
    return np.clip(depth, NEAREST, SKY).astype(np.float32)
