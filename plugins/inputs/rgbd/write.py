"""An RGB-D frame as an input folder: rgb.png, camera.json, depth.npz; with masks masks.png and annotations.json."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plugins.inputs.own_scene import write_config
from plugins.inputs.rgbd.edges import remove_edges
from plugins.inputs.rgbd.frame import TILT, Frame, Labelled, fit_frame
from plugins.inputs.rgbd.surfaces import surface_of
from plugins.names.propose import Proposal
from stages.contracts import Annotations, Camera, InputError
from stages.contracts.doubt import Doubt, DoubtKind
from stages.contracts.parts import says_opening
from stages.contracts.scene_input import write_scene_input
from stages.contracts.scenes import Annotation
from stages.geometry.estimate import TRIM

LONGEST_LABEL = 200  # characters
MOSTLY = 0.8  # share of the proposed names that open, from which on only models that open are compared; chosen
# Depth is good up to the border, few points stray, and what is held in a hand looks down steeply.
FRAME_OPTIONS = {"extraction": {"crop": 1.0, "trim": TRIM, "max_tilt": TILT}}


def opens(label: str, proposals: Sequence[Proposal]) -> bool:
    """Whether what is called so opens; if names are proposed for it, whether most of what they weigh does."""
    weights = [one.probability for one in proposals]
    if not sum(weights):
        return says_opening(label)
    return float(np.average([says_opening(one.name) for one in proposals], weights=weights)) >= MOSTLY


def make_annotations(masks: Labelled) -> tuple[NDArray[np.uint16], Annotations]:
    """masks.png and annotations.json; labels say what is floor or wall, and all floors become one.

    Raises:
        InputError: there is nothing but floor and walls, or a label is no word.
    """
    for label in masks.labels.values():
        if len(label) > LONGEST_LABEL or not label.isprintable():
            what = f"have the label {label[:40]!r}, which cannot be printed or is too long."
            raise InputError("masks", what, f"a word or two, at most {LONGEST_LABEL} characters", code="E-MASKS-NAMES")
    values = masks.values.copy()
    shown = set(np.unique(values).tolist())
    kinds = {value: surface_of(label) for value, label in masks.labels.items() if value in shown}
    floors, walls = ([value for value, kind in kinds.items() if kind == surface] for surface in ("floor", "wall"))
    values[np.isin(values, floors[1:])] = floors[0] if floors else 0
    values[np.isin(values, [value for value, kind in kinds.items() if kind == "nothing"])] = 0
    objects = [
        Annotation(
            mask=value,
            label=masks.labels[value].strip(),
            articulated=opens(masks.labels[value], masks.proposals.get(value, [])),
            doubts=doubt_name(masks.proposals.get(value, [])) + masks.doubts.get(value, []),
            proposals=[one.name for one in masks.proposals.get(value, [])],
            probabilities=[round(one.probability, 4) for one in masks.proposals.get(value, [])],
        )
        for value, kind in kinds.items()
        if not kind
    ]
    if not objects:
        raise InputError(
            "masks", "show no object, only floor and walls.", "name at least one object", code="E-MASKS-EMPTY"
        )
    return values, Annotations(objects=objects, floor=floors[0] if floors else None, walls=walls)


def doubt_name(proposals: list[Proposal]) -> list[Doubt]:
    """That the surest of names is not sure."""
    if not proposals or proposals[0].probability >= DoubtKind.NAME.threshold:
        return []
    first, *others = proposals
    return [
        DoubtKind.NAME.of(name=first.name, share=100 * first.probability, others=" or ".join(o.name for o in others))
    ]


def write_frame(folder: Path, frame: Frame) -> Annotations | None:
    """Write the input folder with `config.yaml`; without masks rgb.png, camera.json and depth.npz alone.

    With masks, depth of their edges is left out.
    """
    frame = fit_frame(frame)
    height, width = frame.rgb.shape[:2]
    camera = Camera(width=width, height=height, intrinsics=frame.intrinsics.tolist(), note=frame.doubt)
    if frame.masks is None:
        write_scene_input(folder, frame.rgb, frame.depth, camera, None, None)
        return None
    masks, annotations = make_annotations(frame.masks)
    depth = remove_edges(frame.depth, frame.masks.values)
    write_scene_input(folder, frame.rgb, depth, camera, masks, annotations)
    write_config(folder, **FRAME_OPTIONS)
    return annotations
