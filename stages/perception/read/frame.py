"""One RGB-D frame as it was found, before it becomes an input folder, and what its labels mean."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.errors import plain_letters
from roomkin.stages.contracts.images import orientation_of
from roomkin.stages.geometry.cameras import scale_intrinsics
from roomkin.stages.perception.classification.names import Proposal

TILT = 75.0  # degrees: largest angle between image-up and the ground's normal, as cameras look down at tables; chosen
LONGEST_SIDE = 1600  # pixels of a picture; larger ones are made smaller; chosen for time
STRETCHED = 0.02  # by which the proportions of two pictures of the same view may differ: rounded sizes; chosen


@dataclass(frozen=True)
class Labelled:
    """values (H, W) uint16, 0: nothing; what each value is called, e.g. {1: "mug", 2: "floor"}; the names that were
    proposed for it, if any were, surest first; what is doubtful about it; what a language model states of it, by keys
    of `Annotation`."""

    values: NDArray[np.uint16]
    labels: dict[int, str]
    proposals: dict[int, list[Proposal]] = field(default_factory=dict)
    doubts: dict[int, list[Doubt]] = field(default_factory=dict)
    stated: dict[int, dict[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Frame:
    """rgb (H, W, 3) uint8; depth (h, w) float32 metres along the optical axis, 0: unknown, of the same view at any
    size; intrinsics (3, 3) in pixels of `rgb`; masks of the size of `rgb`, if there are any; what was found, in lines;
    what is doubtful about the camera or its depth, for the scene's page; floor_from_camera (4, 4), where that is known;
    what the picture is called; SHA-256 of its file.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: NDArray[np.float64]
    masks: Labelled | None = None
    notes: Sequence[str] = ()
    doubt: str = ""
    pose: NDArray[np.float64] | None = None
    picture: str = ""
    digest: str = ""


def is_stretched(one: tuple[float, float], other: tuple[float, float]) -> bool:
    """Whether two sizes (width, height) have other proportions."""
    return abs(one[0] / one[1] / (other[0] / other[1]) - 1) > STRETCHED


def check_upright(path: Path) -> None:
    """Refuse a picture that its EXIF data turn.

    Raises:
        InputError: they do; nothing tells how depth, masks and camera lie on it.
    """
    if (orientation := orientation_of(path)) != 1:
        what = f"is turned by its EXIF data (orientation {orientation}), and nothing tells whether its depth is."
        mend = "save the picture upright, without EXIF data, as the same view as depth and masks"
        raise InputError(path, what, mend, code="E-PICTURE-TURNED")


def fit_frame(frame: Frame) -> Frame:
    """The frame at one size, at most `LONGEST_SIDE` pixels: depth and masks laid on the picture's pixels.

    Raises:
        InputError: depth has other proportions than the picture, so that it is of another view.
    """
    height, width = frame.rgb.shape[:2]
    if is_stretched(frame.depth.shape[::-1], (width, height)):
        what = f"is {frame.depth.shape[1]}x{frame.depth.shape[0]}, the picture {width}x{height}: other proportions."
        raise InputError(
            "depth", what, "align depth to the color picture first (every camera's software does)", code="E-DEPTH-SIZE"
        )
    shrunk = max(1.0, max(width, height) / LONGEST_SIDE)
    size = round(width / shrunk), round(height / shrunk)
    masks = frame.masks and replace(frame.masks, values=_resize_nearest(frame.masks.values, size))
    rgb = frame.rgb if shrunk == 1 else np.asarray(cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA))
    intrinsics = scale_intrinsics(frame.intrinsics, size[0] / width, size[1] / height)
    depth = _resize_nearest(frame.depth, size)
    return replace(frame, rgb=rgb.astype(np.uint8), depth=depth, intrinsics=intrinsics, masks=masks)


def _resize_nearest(array: NDArray, size: tuple[int, int]) -> NDArray:  # type: ignore[type-arg]
    return np.asarray(cv2.resize(array, size, interpolation=cv2.INTER_NEAREST_EXACT), dtype=array.dtype)


Surface = Literal["floor", "wall", "nothing", ""]  # "": a thing

# Everyday words, written by hand, small. What is a thing elsewhere (床: floor or bed; Decke: ceiling or blanket) is
# left out: `doubt_surfaces` sees by its shape what no word tells.
FLOOR = """floor flooring floorboard floorboards ground carpet carpeting parquet linoleum laminate pavement
boden fußboden parkett sol plancher carrelage suelo piso pavimento chao soalho vloer gulv golv lattia podłoga podlaha
podea padlo zemin doseme lantai pod пол підлога падлога под πατωμα δαπεδο أرضية רצפה फर्श พื้น
地板 地面 地砖 地磚 床面 フロア 바닥"""
WALL = """wall wallpaper
wand wande mauer mur cloison pared muro parete pareti parede muri muur vagg væg vegg seina sciana stena zed perete fal
duvar dinding tembok tuong siena zid стена стіна сцяна τοιχος
جدار حائط קיר دیوار दीवार ผนัง กำแพง 墙 墙壁 墙面 墙体 牆 牆壁 牆面 壁 壁面 벽 벽면"""
NOTHING = """background ceiling unknown unlabeled unlabelled void sky
zimmerdecke hintergrund plafond techo soffitto teto sufit strop katto tavan потолок стеля 天井 天花板 背景 천장"""
# Behind the word: COCO's kinds of stuff, sides and numbers.
KINDS = """other merged stuff brick concrete marble panel panels plastic stone tile tiles tiled wood wooden
left right back front rear side north south east west main"""
BEFORE = """of with in behind at on by under near beside above next von aus mit hinter im de del della des du di
da do das avec en con van met"""  # what follows is another thing

Words = frozenset[str]


def _words(text: str) -> Words:
    return frozenset(plain_letters(text).split())


SURFACES: dict[Surface, Words] = {"floor": _words(FLOOR), "wall": _words(WALL), "nothing": _words(NOTHING)}
_KINDS, _BEFORE = _words(KINDS), _words(BEFORE)
_ENGLISH = _words(" ".join(words.splitlines()[0] for words in (FLOOR, WALL, NOTHING)))


def surface_of(label: str) -> Surface:
    """What surface a label means, by the first of its synonyms; "": it means a thing."""
    first = re.split(r"[,;/|(:]", plain_letters(label))[0]
    words = [word for word in re.split(r"[\s\d_.'-]+", first) if word]
    if not words:
        return "" if label.strip("_ ") else "nothing"
    cut = next((k for k, word in enumerate(words) if k and word in _BEFORE), len(words))
    words = words[:cut]
    while len(words) > 1 and words[-1] in _KINDS:
        words.pop()
    for surface, known in SURFACES.items():
        heads = {words[-1], words[-1].removesuffix("s"), *({words[0]} - _ENGLISH)}  # "mur blanc", but "wall cabinet"
        if heads & known:
            return surface
    return ""
