"""Sources of a scene's depth, masks and captions; they lie beside this file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from roomkin.stages.config.inputs import ExtractionConfig
from roomkin.stages.extraction.noise import AnnotatedImage

# The input folder, the options, and random numbers for noise.
Source = Callable[[Path, ExtractionConfig, np.random.Generator], AnnotatedImage]
