"""What a depth camera makes of true depth, and what people and networks make of true outlines. Pure functions."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Masks = NDArray[np.uint16]

MATT, DARK, GLASS, MIRROR = range(4)  # surfaces, as depth cameras tell them apart


@dataclass(frozen=True)
class Device:
    """A camera. Depth is off by `noise` (m at 1 m, growing with the square), alike over `grain` pixels, by a factor of
    `scale` as a whole; known from `near` to `far`, beyond `grazing` (cosine) not, nor beside edges of `shadow` pixels
    (at 1 m of step). `coarse`: one measurement per so many pixels, blended between."""

    name: str
    focal: float
    noise: float
    grain: float
    scale: float
    near: float
    far: float
    grazing: float
    shadow: float
    coarse: float
    handheld: bool


DEVICES = [
    Device("stereo", 608.0, 0.0025, 2.0, 0.008, 0.25, 8.0, 0.10, 9.0, 1.0, False),  # active stereo, 5 cm apart
    Device("structured", 525.0, 0.0015, 1.0, 0.004, 0.45, 6.0, 0.17, 14.0, 1.0, False),  # structured light
    Device("phone", 500.0, 0.0015, 3.0, 0.010, 0.20, 6.0, 0.06, 0.0, 2.5, True),  # a phone's time of flight, 256 x 192
]


@dataclass(frozen=True)
class SensorView:
    """True depth along the axis (H, W; 0: nothing), cosine between ray and surface, depth of what is seen through it or
    in it, and the surface's kind."""

    depth: Floats
    cosine: Floats
    beyond: Floats
    surface: NDArray[np.uint8]


def sense_depth(seen: SensorView, device: Device, rng: np.random.Generator) -> Floats:
    """Depth (H, W) as the device measures it, metres; 0: unknown."""
    shape = seen.depth.shape
    depth = seen.depth.copy()
    through = (seen.surface == MIRROR) | ((seen.surface == GLASS) & (_patches(shape, 6, rng) < 0.6))
    depth[through] = seen.beyond[through]
    known = depth > 0
    if device.coarse > 1:
        depth = _blend_depth(depth, device.coarse)
    step = _lateral(depth, rng)
    noise = _grain(shape, device.grain, rng) * device.noise * step**2
    noisy = step * (1 + device.scale * rng.uniform(-1, 1)) + noise
    lost = (noisy < device.near) | (noisy > device.far) | ~known
    lost |= seen.cosine < device.grazing
    lost |= find_shadow(depth, device.shadow)
    lost |= (seen.surface == DARK) & (_patches(shape, 9, rng) < 0.45)
    lost |= (seen.surface == GLASS) & (_patches(shape, 4, rng) < 0.35)
    lost |= (seen.surface == MIRROR) & (_patches(shape, 14, rng) < 0.3)
    lost |= rng.random(shape) < 0.002
    return np.asarray(np.where(lost, 0.0, noisy))


def _grain(shape: tuple[int, ...], grain: float, rng: np.random.Generator) -> Floats:
    """Normal noise alike over some pixels, of standard deviation 1."""
    noise = cv2.GaussianBlur(rng.standard_normal(shape), (0, 0), grain) if grain > 0 else rng.standard_normal(shape)
    return np.asarray(noise / noise.std())


def _patches(shape: tuple[int, ...], pixels: float, rng: np.random.Generator) -> Floats:
    """A random field in [0, 1], evenly spread, alike over some pixels."""
    field = _grain(shape, pixels, rng).ravel()
    ranks = np.empty(field.size)
    ranks[np.argsort(field)] = np.linspace(0, 1, field.size)
    return ranks.reshape(shape)


def _lateral(depth: Floats, rng: np.random.Generator) -> Floats:
    """Every pixel takes the depth of one up to a pixel beside it: edges are ragged."""
    rows, columns = np.indices(depth.shape)
    rows = np.clip(rows + np.rint(rng.normal(0, 0.6, depth.shape)).astype(int), 0, depth.shape[0] - 1)
    columns = np.clip(columns + np.rint(rng.normal(0, 0.6, depth.shape)).astype(int), 0, depth.shape[1] - 1)
    return np.asarray(depth[rows, columns])


def _blend_depth(depth: Floats, coarse: float) -> Floats:
    """Depth measured at every `coarse`-th pixel and blended between: smeared edges."""
    height, width = depth.shape
    small = cv2.resize(depth, (round(width / coarse), round(height / coarse)), interpolation=cv2.INTER_NEAREST)
    return np.asarray(cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR))


def find_shadow(depth: Floats, pixels: float) -> NDArray[np.bool_]:
    """Where the second eye sees what is nearer: a band to the right of every step, as wide as the step in 1 / depth."""
    if pixels <= 0:
        return np.zeros(depth.shape, dtype=bool)
    width = depth.shape[1]
    inverse = np.where(depth > 0, 1 / np.maximum(depth, 1e-3), 0.0)
    lands = np.arange(width) + pixels * inverse  # column at which the second eye sees a pixel
    return np.asarray(lands < np.maximum.accumulate(lands, axis=1) - 0.5)


def draw_outlines(values: Masks, floors: set[int], rng: np.random.Generator) -> tuple[Masks, dict[int, int]]:
    """Outlines as people and networks draw them: 3 to 5 pixels off, corners cut, thin parts missing, two things in one.

    Args:
        values: (H, W) of things; 0: nothing.
        floors: values of floor and walls, which lie below all others.
        rng: decides.

    Returns:
        The masks, and by value of a thing that is in another's mask that other's value.
    """
    things = [int(v) for v in np.unique(values) if v and v not in floors]
    drawn = np.where(np.isin(values, sorted(floors)), values, 0).astype(np.uint16)
    merged = _merge_small(values, things, rng)
    joined = values.copy()
    for inner, outer in merged.items():
        joined[values == inner] = outer
    order = sorted(set(things) - set(merged), key=lambda v: -int((joined == v).sum()))
    for value in order:
        drawn[_redraw_outline(joined == value, rng)] = value
    return drawn, merged


def _merge_small(values: Masks, things: list[int], rng: np.random.Generator) -> dict[int, int]:
    """In four pictures of ten: one small thing that is part of the mask of what it touches most."""
    if rng.random() > 0.4:
        return {}
    areas = {value: int((values == value).sum()) for value in things}
    small = [value for value in things if areas[value] < 6000]
    rng.shuffle(small)
    for value in small:
        ring = cv2.dilate((values == value).astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
        around = values[ring & (values != value)]
        touched = [other for other in things if other != value and (around == other).sum() > 0.4 * len(around)]
        if touched:
            return {value: touched[0]}
    return {}


def _redraw_outline(mask: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
    """One outline drawn anew: larger or smaller by up to 5 pixels, moved by up to 3, its corners cut."""
    area = int(mask.sum())
    off = int(rng.integers(-4, 6))
    if area < 900:
        off = int(np.clip(off, -1, 2))
    size = 2 * abs(off) + 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    shape = mask.astype(np.uint8)
    if rng.random() < 0.35 and area > 2500:  # thin parts are lost: legs, arms, leaves
        opened = cv2.morphologyEx(shape, cv2.MORPH_OPEN, np.ones((9, 9), np.uint8))
        shape = opened if opened.sum() > 0.4 * area else shape
    changed = cv2.dilate(shape, kernel) if off > 0 else cv2.erode(shape, kernel)
    shape = changed if changed.sum() > 0.3 * area else shape
    outlines, _ = cv2.findContours(shape, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    corners = [cv2.approxPolyDP(outline, rng.uniform(1.0, 3.0), True) for outline in outlines]
    largest = max((cv2.contourArea(outline) for outline in outlines), default=0.0)
    kept = [c for c, o in zip(corners, outlines, strict=True) if cv2.contourArea(o) >= 0.05 * largest]
    canvas = np.zeros_like(shape)
    cv2.fillPoly(canvas, kept, 1)
    dx, dy = (int(v) for v in rng.integers(-2, 3, 2)) if area > 900 else (0, 0)
    moved = np.zeros_like(canvas)
    height, width = canvas.shape
    moved[max(0, dy) : height + min(0, dy), max(0, dx) : width + min(0, dx)] = canvas[
        max(0, -dy) : height + min(0, -dy), max(0, -dx) : width + min(0, -dx)
    ]
    return np.asarray(moved.astype(bool))
