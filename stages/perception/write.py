"""An RGB-D frame as an input folder: rgb.png, camera.json, depth.npz; with masks masks.png and annotations.json."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.inputs import scene_of_folder
from roomkin.stages.contracts import Annotations, Camera, InputError, read_json, write_text
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.images import color_of
from roomkin.stages.contracts.parts import says_opening
from roomkin.stages.contracts.scene_input import write_scene_input
from roomkin.stages.contracts.scenes import Annotation
from roomkin.stages.contracts.things import Found, Name
from roomkin.stages.geometry.robust import TRIM
from roomkin.stages.perception.classification.names import LikelyName, Names
from roomkin.stages.perception.read.frame import TILT, Frame, Labelled, fit_frame, surface_of
from roomkin.stages.perception.read.mask_pieces import remove_edges
from roomkin.stages.plugins import PACKAGES

LONGEST_LABEL = 200  # characters
NAMES = 5  # of a thing that are told; chosen
MOSTLY = 0.8  # share of the proposed names that open, from which on only models that open are compared; chosen
# Depth is good up to the border, few points stray, and what is held in a hand looks down steeply.
FRAME_OPTIONS = {"extraction": {"crop": 1.0, "trim": TRIM, "max_tilt": TILT}}


def opens(label: str, proposals: Sequence[LikelyName]) -> bool:
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
        ).model_copy(update=masks.stated.get(value, {}))
        for value, kind in kinds.items()
        if not kind
    ]
    if not objects:
        what = "show no object, only floor and walls."
        raise InputError("masks", what, "name at least one object", code="E-MASKS-EMPTY")
    return values, Annotations(objects=objects, floor=floors[0] if floors else None, walls=walls)


def tell_names(names: Names) -> Found:
    """The names of a thing for people and pages."""
    told = [Name(name=one.name, probability=round(one.probability, 4)) for one in names.proposals[:NAMES]]
    return Found(names=told, other=round(names.other, 4))


def doubt_name(proposals: Sequence[LikelyName | Name]) -> list[Doubt]:
    """That the surest of names is not sure."""
    if not proposals or proposals[0].probability >= DoubtKind.NAME.threshold:
        return []
    first, *others = proposals
    named = " or ".join(one.name for one in others)
    return [DoubtKind.NAME.of(name=first.name, share=100 * first.probability, others=named)]


def check_folder(folder: Path, digest: str) -> None:
    """Refuse an input folder that holds another picture than that of the file of this SHA-256.

    Raises:
        InputError: it does.
    """
    camera = folder / "camera.json"
    known = read_json(Camera, camera) if camera.is_file() else None
    if known is not None and digest and known.digest not in ("", digest):
        what = f"holds another picture{f', {known.picture!r}' if known.picture else ''}: see rgb.png in it."
        raise InputError(folder, what, "give another --out, or delete it", code="E-PICTURE-OTHER")


def write_frame(folder: Path, frame: Frame) -> Annotations | None:
    """Write the input folder with `config.yaml`; without masks rgb.png, camera.json and depth.npz alone. With masks,
    depth of their edges is left out."""
    check_folder(folder, frame.digest)
    frame = fit_frame(frame)
    height, width = frame.rgb.shape[:2]
    pose, matrix = None if frame.pose is None else frame.pose.tolist(), frame.intrinsics.tolist()
    about = {"note": frame.doubt, "picture": frame.picture, "digest": frame.digest}
    camera = Camera(width=width, height=height, intrinsics=matrix, floor_from_camera=pose, **about)
    if frame.masks is None:
        write_scene_input(folder, frame.rgb, frame.depth, camera, None, None)
        return None
    masks, annotations = make_annotations(frame.masks)
    depth = remove_edges(frame.depth, frame.masks.values)
    write_scene_input(folder, frame.rgb, depth, camera, masks, annotations)
    write_config(folder, **FRAME_OPTIONS)
    return annotations


def is_clone() -> bool:
    """Whether Snakemake finds the workflow where this process runs."""
    return Path("Snakefile").is_file() or Path("workflow/Snakefile").is_file()


def to_run(words: str) -> str:
    """A Snakemake command line that works from here: a clone's workflow runs there, or where results are; an installed
    one everywhere."""
    home = PACKAGES.parent
    if is_clone():
        return f"snakemake {words}"
    if (home / "pyproject.toml").is_file() and not Path("results").is_dir():
        return f"cd {shlex.quote(str(home))} && snakemake {words}"
    return f"snakemake --snakefile {shlex.quote(str(home / 'Snakefile'))} {words}"


def write_config(folder: Path, **sections: dict[str, Any]) -> Path:
    """Write `config.yaml` into an input folder: a config with that folder as its only scene, and no policies.

    `snakemake --configfile folder/config.yaml -- pages` then goes from it to scenes of cousins and a page about them.
    `sections`: further keys of the config that fit the folder.
    """
    scene = scene_of_folder(folder)
    targets = dict.fromkeys(ExperimentConfig().targets)  # null: the default run's objects are not in this picture
    experiment = {"rooms": [scene], "inputs": {scene: folder.as_posix()}, "targets": targets}
    path = folder / "config.yaml"
    write_text(path, yaml.safe_dump({"experiment": experiment, **sections}, sort_keys=False))
    return path


def draw_numbers(rgb: NDArray[np.uint8], masks: Sequence[NDArray[np.bool_]]) -> NDArray[np.uint8]:
    """The picture with masks tinted, each with its number, from 1, where it is widest."""
    shown = rgb.copy()
    for k, mask in enumerate(masks):
        shown[mask] = (0.5 * rgb[mask] + 0.5 * np.array(color_of(k))).astype(np.uint8)
    size = max(0.5, max(rgb.shape) / 500)
    for k, mask in enumerate(masks):
        if not mask.any():  # all of it lies behind others
            continue
        inside = np.pad(mask, 1).astype(np.uint8)
        _, _, _, (x, y) = cv2.minMaxLoc(cv2.distanceTransform(inside, cv2.DIST_L2, 3))
        (width, height), _ = cv2.getTextSize(str(k + 1), cv2.FONT_HERSHEY_SIMPLEX, size, round(3 * size))
        at = (x - 1 - width // 2, y - 1 + height // 2)
        for color, thickness in (((0, 0, 0), 5), ((255, 255, 255), 2)):
            cv2.putText(shown, str(k + 1), at, cv2.FONT_HERSHEY_SIMPLEX, size, color, round(thickness * size))
    return shown
