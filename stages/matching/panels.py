"""How far a model's doors and drawers are from where they are said to lie on the front."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from stages.contracts.fronts import Panel
from stages.contracts.library import LibraryEntry
from stages.contracts.objects import SceneObject
from stages.matching.candidates import count_gap


def panel_gap(item: SceneObject, entry: LibraryEntry) -> float:
    """Doors and drawers that are not where they are said to be; by their numbers alone where either is not known."""
    return layout_gap(item.panels, entry.panels) if item.panels and entry.panels else float(count_gap(item, entry))


def layout_gap(said: Sequence[Panel], own: Sequence[Panel]) -> float:
    """Sum of 1 - IoU over pairs of the same kind, paired so that it is least, and 1 for each without a partner.

    With all of them in place it is |d doors| + |d drawers| (`count_gap`).
    """
    gap = 0.0
    for kind in ("door", "drawer"):
        ours = [panel for panel in said if panel.kind == kind]
        theirs = [panel for panel in own if panel.kind == kind]
        apart = 1 - overlaps(ours, theirs)
        gap += float(apart[linear_sum_assignment(apart)].sum()) + abs(len(ours) - len(theirs))
    return gap


def overlaps(ours: Sequence[Panel], theirs: Sequence[Panel]) -> NDArray[np.float64]:
    """Intersection over union (N, M) of panels."""
    if not ours or not theirs:
        return np.zeros((len(ours), len(theirs)))
    a, b = _boxes(ours)[:, None], _boxes(theirs)[None]
    shared = np.maximum(np.minimum(a[..., 1], b[..., 1]) - np.maximum(a[..., 0], b[..., 0]), 0).prod(axis=-1)
    areas = [(box[..., 1] - box[..., 0]).prod(axis=-1) for box in (a, b)]
    return np.asarray(shared / (areas[0] + areas[1] - shared))


def _boxes(panels: Sequence[Panel]) -> NDArray[np.float64]:
    """(N, 2, 2): across and up; from, to."""
    return np.array([[(panel.left, panel.right), (panel.bottom, panel.top)] for panel in panels])
