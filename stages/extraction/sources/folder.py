"""Source `folder`: all from files of the input folder; exact depth is made as bad as estimated depth."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from stages.config.extraction import ExtractionConfig
from stages.extraction.noise import noisy_depth
from stages.extraction.observation import AnnotatedImage, read_folder


def observe(folder: Path, options: ExtractionConfig, rng: np.random.Generator) -> AnnotatedImage:
    """Read the input folder; with `depth_noise: model`, disturb its depth if that is exact."""
    image = read_folder(folder)
    if options.depth_noise == "none" or not image.exact:
        return image
    return replace(image, depth=noisy_depth(image.depth, options.noise, rng), exact=False)
