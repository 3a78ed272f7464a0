"""Command `estimate`: one RGB picture -> an input folder, by pretrained networks."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plugins.inputs.config import PhotoConfig
from plugins.inputs.own_scene import write_config
from plugins.inputs.photo.captions import NONE, ask_labels, ask_mounting, ask_object
from plugins.inputs.photo.level import level_camera
from plugins.inputs.photo.networks import Detection, depth_of, detect, segment
from plugins.inputs.photo.picture import Photo, read_photo
from plugins.inputs.photo.segments import propose, usual_focal
from plugins.inputs.rgbd.cameras import Matrix, intrinsics_of_view
from plugins.inputs.rgbd.frame import Frame, Labelled
from plugins.inputs.rgbd.write import make_annotations
from plugins.vlm.ask import Asker, NoAnswerError
from plugins.vlm.config import VlmConfig
from stages.cli import progress
from stages.contracts import Annotations, Camera, InputError, read_options
from stages.contracts.categories import known_categories
from stages.contracts.scene_input import write_scene_input
from stages.contracts.scenes import Annotation, Held
from stages.contracts.types import FLOOR, WALL
from stages.geometry.cameras import make_intrinsics

ROOM = (FLOOR, WALL)  # labels of what is no object


@dataclass(frozen=True)
class Thing:
    """A detection with its mask (H, W), and what the language model states of it."""

    detection: Detection
    mask: NDArray[np.bool_]
    articulated: bool | None = None  # None: by its label
    doors: int = 0
    drawers: int = 0
    mounting: tuple[int, list[int]] | None = None  # type and walls, by their place among the walls; None: by geometry


def run(*, image: Path, out: Path, options: str = "", device: str = "cpu") -> None:
    """Find what a picture shows, where and how far, and write it as an input folder.

    Args:
        image: the picture.
        out: the folder to write: rgb.png, camera.json, depth.npz, masks.png, annotations.json, config.yaml.
        options: JSON of the config section `photo`.
        device: cpu or cuda.
    """
    settings = read_options(PhotoConfig, options)
    photo = read_photo(image, Path(settings.lens) if settings.lens else None)
    if photo.shrunk > 1:
        print(f"{image}: made smaller, to {photo.rgb.shape[1]}x{photo.rgb.shape[0]} pixels")
    model = VlmConfig.model_validate(settings.vlm)
    asker = Asker(model) if settings.captions == "vlm" else None
    labels = settings.labels or [name.replace("_", " ") for name in known_categories()]
    if asker is not None:
        try:
            labels = ask_labels(asker, photo.rgb)
        except NoAnswerError as error:
            raise InputError(
                model.url,
                f"says not what is in the picture ({error}).",
                "photo.captions: labels needs no language model",
                code="E-VLM-ANSWER",
            ) from None
        print(f"{model.model} lists {', '.join(labels)}")
    depth = depth_of(photo.rgb, settings, device)
    intrinsics, line = camera_of(photo, settings)
    print(line)
    things = find_things(photo.rgb, labels, settings, device)
    if asker is None:
        print("no language model was asked: what opens follows from its label; doors and drawers are not counted")
    else:
        things = recaption(asker, photo.rgb, things, labels)
        if settings.mounting == "vlm":
            things = ask_mountings(asker, photo.rgb, things)
        print(asker.summary())
    written = write(out, Frame(photo.rgb, depth, intrinsics), things, line)
    print(f"{out}: {len(written.objects)} objects, {'a' if written.floor else 'no'} floor, {len(written.walls)} walls")


def camera_of(photo: Photo, options: PhotoConfig) -> tuple[Matrix, str]:
    """K, and a line with the source of its focal length: config, EXIF, lines, a usual camera."""
    height, width = photo.rgb.shape[:2]
    prior = usual_focal(width, height, photo.focal)
    if options.field_of_view is not None:
        focal, source = float(intrinsics_of_view(options.field_of_view, width, height)[0, 0]), "photo.field_of_view"
    elif photo.focal is not None:
        focal, source = photo.focal, "EXIF" if options.lens is None else "photo.lens"
    else:
        proposed = propose(np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.uint8), prior)
        usual = "a usual camera, as nothing tells it: photo.field_of_view sets it"
        focal, source = proposed.likely_focal, "lines in the picture" if proposed.guides else usual
    degrees = np.rad2deg(2 * np.arctan(width / 2 / focal))
    return (
        make_intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2),
        f"focal length {focal:.0f} pixels, {degrees:.0f} degrees across: by {source}",
    )


def find_things(rgb: NDArray[np.uint8], labels: list[str], options: PhotoConfig, device: str = "cpu") -> list[Thing]:
    """What the detector finds, with masks, best first; floor and walls among them.

    Raises:
        InputError: it finds nothing.
    """
    detections = detect(rgb, [*labels, *ROOM], options, device)
    if all(item.label in ROOM for item in detections):
        fix = "lower photo.box_threshold, name it in photo.labels, or draw it: python -m plugins.annotator annotate"
        raise InputError("photo", "the detector finds no object in the picture.", fix, code="E-SCENE-EMPTY")
    things: list[Thing] = []
    least = max(1.0, options.min_share * rgb.shape[0] * rgb.shape[1])
    for detection, mask in zip(detections, segment(rgb, detections, options, device), strict=True):
        if mask.sum() >= least and not any(_overlap(mask, kept.mask) > options.overlap for kept in things):
            things.append(Thing(detection, mask))
    return things


def _overlap(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> float:
    return float((one & other).sum() / max(1, (one | other).sum()))


def recaption(asker: Asker, rgb: NDArray[np.uint8], things: list[Thing], labels: list[str]) -> list[Thing]:
    """Detections with the labels that the language model gives them; those without a label are left out."""
    kept = []
    for number, thing in enumerate(progress(things, "objects"), 1):
        detection = thing.detection
        if detection.label in ROOM:
            kept.append(thing)
            continue
        about = f"object {number}, {detection.label}"
        try:
            answer = ask_object(asker, rgb, detection.box, labels, about)
        except NoAnswerError as error:
            print(f"{about}: no answer ({error}): the detector's label stays")
            kept.append(thing)
            continue
        if answer.label == NONE:
            print(f"{about}: is no whole object, says {asker.options.model}: left out")
            continue
        if answer.label != detection.label:
            print(f"{about}: is a {answer.label}, says {asker.options.model}")
        named = detection._replace(label=answer.label)
        kept.append(Thing(named, thing.mask, answer.articulated, answer.doors, answer.drawers))
    return kept


def ask_mountings(asker: Asker, rgb: NDArray[np.uint8], things: list[Thing]) -> list[Thing]:
    """Detections with the mountings that the language model states; None without a usable answer."""
    walls = [thing.mask for thing in things if thing.detection.label == WALL]
    if not walls:
        print("no wall is found: mounting by geometry")
        return things
    found = []
    for number, thing in enumerate(progress(things, "mountings"), 1):
        label = thing.detection.label
        if label not in ROOM:
            about = f"object {number}, {label}: mounting"
            try:
                thing = replace(thing, mounting=ask_mounting(asker, rgb, thing.detection.box, walls, label, about))
            except NoAnswerError as error:
                print(f"{about} by geometry, no answer ({error})")
        found.append(thing)
    return found


def write(folder: Path, frame: Frame, things: list[Thing], note: str = "") -> Annotations:
    """Write the five files and `config.yaml`; of masks that overlap the smaller one is on top, the room lies below.

    Raises:
        InputError: no object is left, or no pixel of one.
    """
    height, width = frame.rgb.shape[:2]
    values = np.zeros((height, width), dtype=np.uint16)
    order = sorted(enumerate(things, 1), key=lambda each: (each[1].detection.label not in ROOM, -each[1].mask.sum()))
    for value, thing in order:
        values[thing.mask] = value
    labelled = Labelled(values, {value: thing.detection.label for value, thing in enumerate(things, 1)})
    masks, annotations = make_annotations(labelled)
    pose = level_camera(replace(frame, masks=Labelled(masks, labelled.labels)), annotations.floor)
    if pose is not None:
        line = f"no floor is seen: level by lines in the picture, {pose[2, 3]:.2f} m above the lowest point"
        print(line)
        note = f"{note}; {line}" if note else line
    walls = [value for value, thing in enumerate(things, 1) if thing.detection.label == WALL]
    stated = [_state(item, things[item.mask - 1], walls, annotations.walls) for item in annotations.objects]
    annotations = annotations.model_copy(update={"objects": stated})
    camera = Camera(
        width=width,
        height=height,
        intrinsics=np.asarray(frame.intrinsics).tolist(),
        floor_from_camera=None if pose is None else pose.tolist(),
        note=note,
    )
    write_scene_input(folder, frame.rgb, frame.depth, camera, masks, annotations)
    write_config(folder)
    return annotations


def _state(item: Annotation, thing: Thing, walls: list[int], shown: list[int]) -> Annotation:
    """An annotation with what the language model states; its mounting only if its walls are seen, too.

    `walls`, `shown`: mask values of all walls, and of those with pixels left.
    """
    stated: dict[str, Any] = {}
    if thing.articulated is not None:
        stated |= {"articulated": thing.articulated, "doors": thing.doors, "drawers": thing.drawers}
    if thing.mounting is not None:
        kind, places = thing.mounting
        touched = [walls[place] for place in places if walls[place] in shown]
        if len(touched) < len(places):
            print(f"{item.label}: mounting by geometry, its wall is all covered")
        else:
            stated["mounting"] = Held.model_validate({"type": kind, "walls": touched})
    return item.model_copy(update=stated)
