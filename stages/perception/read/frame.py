"""One RGB-D frame as it was found, before it becomes an input folder, and what its labels mean.

Whether depth belongs to its picture: where depth changes by steps the picture has edges, and masks have outlines.

Measured on ray-cast rooms and on the frames of real cameras: docs/results/your-data.md.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d, distance_transform_edt

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.errors import plain_letters
from roomkin.stages.contracts.images import orientation_of
from roomkin.stages.geometry.frames import scale_intrinsics
from roomkin.stages.perception.classification.names import LikelyName

TILT = 75.0  # degrees: largest angle between image-up and the ground's normal, as cameras look down at tables; chosen
LONGEST_SIDE = 1600  # pixels of a picture; larger ones are made smaller; chosen for time
STRETCHED = 0.02  # by which the proportions of two pictures of the same view may differ: rounded sizes; chosen
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
# Of whether depth belongs to its picture.
WIDTH = 640  # pixels at most of what is compared; larger frames are made smaller
STEP = 0.03  # share of the distance
FEWEST, SAMPLED = 200, 1000  # pixels of steps: with fewer nothing is said, of more so many are looked at
NEIGHBOURS = np.ones((5, 5))  # a step in so many pixels around an edge is on it
AROUND = 41  # pixels across which an edge is compared with what else is there: carpets are full of edges
FARTHEST, APART = 0.15, 6  # share of the width by which depth may be moved, and pixels between places that are tried
ZOOMS = [float(zoom) for zoom in np.exp(0.04 * np.arange(-10, 11))]  # by which depth may have to be shown larger
BETTER = 0.06  # how much more steps fit elsewhere; of right frames at most 0.035
SURE, FITS = 0.1, 0.75  # likewise, and how much steps fit there, where depth is refused
NOWHERE = 0.57  # how much steps fit at least in right frames: 0.6; by chance 0.5
FLIPS = {"left to right": (1,), "upside down": (0,), "by 180 degrees": (0, 1)}
Mask = NDArray[np.bool_]
Edges = NDArray[np.float32]


@dataclass(frozen=True)
class Labelled:
    """values (H, W) uint16, 0: nothing; what each value is called, e.g. {1: "mug", 2: "floor"}; the names that were
    proposed for it, if any were, surest first; what is doubtful about it; what a language model states of it, by keys
    of `Annotation`."""

    values: NDArray[np.uint16]
    labels: dict[int, str]
    proposals: dict[int, list[LikelyName]] = field(default_factory=dict)
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
        fix = "align depth to the color picture first (every camera's software does)"
        raise InputError("depth", what, fix, code="E-DEPTH-SIZE")
    shrunk = max(1.0, max(width, height) / LONGEST_SIDE)
    size = round(width / shrunk), round(height / shrunk)
    masks = frame.masks and replace(frame.masks, values=_resize_nearest(frame.masks.values, size))
    rgb = frame.rgb if shrunk == 1 else np.asarray(cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA))
    intrinsics = scale_intrinsics(frame.intrinsics, size[0] / width, size[1] / height)
    depth = _resize_nearest(frame.depth, size)
    return replace(frame, rgb=rgb.astype(np.uint8), depth=depth, intrinsics=intrinsics, masks=masks)


def _resize_nearest(array: NDArray, size: tuple[int, int]) -> NDArray:  # type: ignore[type-arg]
    return np.asarray(cv2.resize(array, size, interpolation=cv2.INTER_NEAREST_EXACT), dtype=array.dtype)


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


class Place(NamedTuple):
    """How much steps are on edges (0..1) if depth is shown `zoom` times larger, and moved by so many pixels."""

    fit: float
    zoom: float = 1.0
    right: int = 0
    down: int = 0


def doubt_depth(depth: NDArray[np.float32], rgb: NDArray[np.uint8], masks: NDArray[np.uint16] | None = None) -> str:
    """What makes it doubtful that depth (H, W) is of the view of rgb (H, W, 3) and masks (H, W); "" if nothing.

    Raises:
        InputError: it fits when it is mirrored, or shown larger or smaller.
    """
    if (shrunk := depth.shape[1] / WIDTH) > 1:
        size = WIDTH, round(depth.shape[0] / shrunk)
        depth = np.asarray(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST))
        rgb = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)).astype(np.uint8)
        masks = None if masks is None else np.asarray(cv2.resize(masks, size, interpolation=cv2.INTER_NEAREST))
    steps = np.argwhere(find_steps(depth)) if (depth > 0).any() else np.empty((0, 2))
    if len(steps) < FEWEST:
        return ""
    steps = steps[np.linspace(0, len(steps) - 1, SAMPLED).astype(int)] - (np.array(depth.shape) - 1) / 2
    edges = _find_edges(rgb, masks)
    shows_much = bool(np.median(edges) > 0)
    edges = np.pad(edges, depth.shape[1], constant_values=-1)
    farthest = round(FARTHEST * depth.shape[1]) // APART * APART
    tried = range(-farthest, farthest + 1, APART)
    moves = [(right, down) for right in tried for down in tried]
    here = _fit(edges, steps, 1.0, [(0, 0)])
    moved = _fit(edges, steps, 1.0, moves)
    best = max(moved, *(_fit(edges, steps, zoom, moves) for zoom in ZOOMS if zoom != 1))
    flips = {how: _fit(np.flip(edges, axes), steps, 1.0, moves) for how, axes in FLIPS.items()}
    turned = max(flips, key=lambda how: flips[how].fit)
    if flips[turned].fit > max(moved.fit + BETTER, best.fit - BETTER, NOWHERE):
        what = f"is turned {turned} against the picture: {_compare(here, flips[turned])}."
        fix = f"turn depth {turned}, or picture and masks, as the camera saw them"
        raise InputError("depth", what, fix, code="E-DEPTH-MIRRORED")
    is_near = best.zoom == 1 and max(abs(best.right), abs(best.down)) <= APART
    if best.fit <= max(here.fit + BETTER, NOWHERE) or is_near:
        if not shows_much or here.fit >= NOWHERE:
            return ""
        nowhere = f"depth in doubt: its steps fit the picture's edges by {100 * here.fit:.0f} %, by chance 50"
        return f"{nowhere}: it is not aligned to the picture, or of another one"
    is_zoomed = best.fit > moved.fit + BETTER
    if not is_zoomed and moved.fit > here.fit + BETTER:
        best = moved
    how = _say_place(best, depth.shape)
    if is_zoomed and best.fit > max(here.fit + SURE, FITS):
        what = f"is of another camera than the picture, or place: it fits if it is {how}: {_compare(here, best)}."
        fix = "align depth to the color picture (every camera's software does)"
        raise InputError("depth", what, fix, code="E-DEPTH-UNALIGNED")
    return f"depth in doubt: it fits if it is {how}: {_compare(here, best)}; it is not aligned to the picture"


def _compare(here: Place, there: Place) -> str:
    return f"its steps fit the picture's edges by {100 * there.fit:.0f} %, now by {100 * here.fit:.0f}"


def _say_place(place: Place, shape: tuple[int, ...]) -> str:
    zoom = place.zoom if place.zoom > 1 else 1 / place.zoom
    shown = [] if place.zoom == 1 else [f"shown {zoom:.2f} times {'larger' if place.zoom > 1 else 'smaller'}"]
    right, down = 100 * place.right / shape[1], 100 * place.down / shape[0]
    moved = [f"moved by {right:+.0f} % of the width and {down:+.0f} % of the height"] if right or down else []
    return " and ".join(shown + moved)


def find_steps(depth: NDArray[np.float32]) -> Mask:
    """Where depth (H, W), 0: unknown, changes by a step; gaps are filled with what is nearest to them."""
    rows, columns = distance_transform_edt(depth <= 0, return_distances=False, return_indices=True)
    inverse = 1 / np.maximum(cv2.medianBlur(depth[rows, columns], 5), 1e-6)
    bend = [1, 0, 0, -2, 0, 0, 1]  # 0 on planes
    return np.asarray(np.max([np.abs(correlate1d(inverse, bend, axis)) for axis in (0, 1)], axis=0) > STEP * inverse)


def _find_edges(rgb: NDArray[np.uint8], masks: NDArray[np.uint16] | None) -> Edges:
    """How strong the edges at each pixel are (H, W): the share of all pixels that have weaker ones; outlines are 1."""
    smooth = cv2.GaussianBlur(rgb, (0, 0), 1.2).astype(np.float32)
    change = np.hypot(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)).max(axis=2)
    strength = cv2.dilate(change / (cv2.blur(change, (AROUND, AROUND)) + 2), NEIGHBOURS)
    if masks is not None:
        outline = cv2.dilate(masks, np.ones((3, 3))) != cv2.erode(masks, np.ones((3, 3)))
        strength[cv2.dilate(outline.astype(np.uint8), NEIGHBOURS) > 0] = np.inf
    return (np.searchsorted(np.sort(strength.ravel()), strength) / strength.size).astype(np.float32)


def _fit(edges: Edges, steps: NDArray[np.float64], zoom: float, moves: list[tuple[int, int]]) -> Place:
    """The best of the moves of steps (N, 2: rows and columns from the center) that are shown `zoom` times larger. Edges
    below 0 lie beyond the picture; of steps there, up to half of all, nothing is known."""
    wide = edges.shape[1]
    rows, columns = np.rint((np.array(edges.shape) - 1) / 2 + zoom * steps).astype(int).T
    flat = rows * wide + columns
    found = edges.ravel()[flat + np.array([[down * wide + right] for right, down in moves])]
    inside = found >= 0
    fits = np.where(inside, found, 0).sum(axis=1) / np.maximum(inside.sum(axis=1), len(steps) / 2)
    best = int(fits.argmax())
    return Place(float(fits[best]), zoom, *moves[best])
