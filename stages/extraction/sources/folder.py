"""Source `folder`: all from files of the input folder; exact depth gets the errors of estimated depth."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.contracts.objects import DepthError
from roomkin.stages.extraction.noise import EXACT, AnnotatedImage, noisy_depth, read_folder


def observe(folder: Path, options: ExtractionConfig, rng: np.random.Generator) -> AnnotatedImage:
    """Read the input folder; with `depth_noise: model`, disturb its depth if that is exact."""
    image = read_folder(folder)
    if options.depth_noise == "none" or image.depth_error != EXACT:
        return image
    noise = options.noise
    error = DepthError(noise.range_constant, noise.range_quadratic)
    return replace(image, depth=noisy_depth(image.depth, noise, rng), depth_error=error)
