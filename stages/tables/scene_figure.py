"""Figure 6: each room beside its reconstruction."""

from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import NDArray

from roomkin.stages.contracts.images import read_narrow
from roomkin.stages.tables.drawing import mark_not_run
from roomkin.stages.tables.order import sort_key, title


def figure6(pictures: dict[tuple[str, str], Path], rooms: list[str], width: int) -> Figure:
    """A grid of comparison pictures (input beside reconstruction): a row per room, a column per variant.

    Args:
        pictures: (room, variant) -> picture; the variant may be ''.
        rooms: rooms that get a row even if they were not run.
        width: of a picture, pixels at most.
    """
    names = sorted({*rooms, *(room for room, _ in pictures)}, key=sort_key)
    variants = sorted({variant for _, variant in pictures}) or [""]
    images: dict[tuple[str, str], NDArray[np.uint8]] = {
        key: np.asarray(read_narrow(path, width)) for key, path in pictures.items()
    }
    ratio = max((image.shape[0] / image.shape[1] for image in images.values()), default=0.4)
    missing = [name for name in names if not any((name, variant) in images for variant in variants)]
    heights = [0.05 if name in missing else ratio for name in names]
    inches = 6.0 if len(variants) == 1 else 4.2
    figure, axes = plt.subplots(
        len(names), len(variants), squeeze=False, layout=ConstrainedLayoutEngine(h_pad=0.02, hspace=0.01),
        figsize=(inches * len(variants) + 0.7, inches * sum(heights) + 0.09 * len(names) + 0.3),
        gridspec_kw={"height_ratios": heights},
    )  # fmt: skip
    for row, name in enumerate(names):
        for column, variant in enumerate(variants):
            panel = axes[row, column]
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
            if (name, variant) in images:
                panel.imshow(images[name, variant], interpolation="lanczos")
            else:
                panel.set_facecolor("#f3f1ea")
                mark_not_run(panel)
            if row == 0 and variant:
                panel.set_title(f"input and reconstruction, variant ({variant})")
        axes[row, 0].set_ylabel(title(name), rotation=0, ha="right", va="center")
    return figure
