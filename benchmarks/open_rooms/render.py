"""A room as a photograph: path-traced by Mitsuba 3 (`pip install mitsuba`), which nothing else of the project needs."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from benchmarks.open_rooms.packs import FLOORS, WALLS, PaintedMesh, texture
from benchmarks.open_rooms.rooms import HEIGHT, OpenRoom
from benchmarks.open_rooms.sensor import GLASS, MIRROR, Floats
from benchmarks.open_rooms.views import HEIGHT_PX, WIDTH, PlacedMesh, intrinsics, surfaces
from roomkin.stages.contracts import InputError

DEPTH = 5  # bounces
TILE = {"floor": 1.2, "wall": 1.6}  # metres that a texture covers
PAINTS = [(0.82, 0.80, 0.74), (0.70, 0.76, 0.78), (0.80, 0.72, 0.64), (0.75, 0.78, 0.70)]
UPSIDE_DOWN = {"work", "held_out", "third"}  # where pictures on OBJs are so, and stay as they were rendered
LAMP, WINDOW = 1.6, 3.0  # radiance of the ceiling and of the window behind the camera


def photograph(
    room: OpenRoom, half: str, packs: Path, pose: Floats, focal: float, samples: int, seed: int
) -> Image.Image:
    """The picture of a room, 640 x 480.

    Args:
        room: as `furnish` made it.
        half: whose textures floor and walls have.
        packs: folder of `fetch`.
        pose: world_from_camera (4, 4).
        focal: pixels.
        samples: per pixel.
        seed: of light, colors and noise.

    Raises:
        InputError: Mitsuba is not installed.
    """
    try:
        import mitsuba as mi
    except ImportError:
        what = "Mitsuba 3 is not installed, which renders the pictures."
        mend = "pip install mitsuba==3.9.1"
        raise InputError("benchmarks.open_rooms render", what, mend, code="E-PACKAGE-MISSING") from None
    mi.set_variant("scalar_rgb")
    rng = np.random.default_rng(seed)
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH},
        "sensor": _sensor(mi, pose, focal, samples, seed),
        **_lights(mi, room, rng),
    }
    papered = _paper_room(half, packs, rng)
    for number, surface in enumerate(surfaces(room)):
        bsdf = papered[number] if number < len(papered) else _make_material(mi, surface)
        part = surface.part
        if part.uv is not None and half not in UPSIDE_DOWN:  # Mitsuba counts v from above
            part = replace(part, uv=part.uv * [1, -1] + [0, 1])
        scene[f"mesh_{number}"] = _mesh(mi, part, bsdf, f"mesh_{number}")
    image = mi.render(mi.load_dict(scene), seed=seed)
    pixels = _without_fireflies(np.clip(np.array(image)[..., :3], 0, None))
    pixels = pixels / max(float(np.quantile(pixels, 0.97)), 1e-6) * rng.uniform(0.85, 1.05)
    shown = np.where(pixels < 0.0031308, 12.92 * pixels, 1.055 * np.maximum(pixels, 1e-9) ** (1 / 2.4) - 0.055)
    quiet = cv2.fastNlMeansDenoisingColored((255 * np.clip(shown, 0, 1)).astype(np.uint8), None, 5, 5, 5, 15)
    return Image.fromarray(np.clip(quiet + rng.normal(0, 1.5, quiet.shape), 0, 255).astype(np.uint8))


def _without_fireflies(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Pixels far brighter than all around them take the median there."""
    around = cv2.medianBlur(pixels.astype(np.float32), 3)
    bright = pixels.max(axis=2) > 1.6 * around.max(axis=2) + 0.02
    return np.where(bright[..., None], around, pixels)


def _sensor(mi: Any, pose: Floats, focal: float, samples: int, seed: int) -> dict[str, Any]:
    """Mitsuba's camera looks along +z with x to the left and y up."""
    flipped = pose @ np.diag([-1.0, -1.0, 1.0, 1.0])
    k = intrinsics(focal)
    return {
        "type": "perspective",
        "fov": float(np.rad2deg(2 * np.arctan(WIDTH / 2 / k[0, 0]))),
        "fov_axis": "x",
        "near_clip": 0.01,
        "to_world": mi.ScalarTransform4f(flipped),
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT_PX, "rfilter": {"type": "gaussian"}},
        "sampler": {"type": "independent", "sample_count": samples, "seed": seed},
    }


def _lights(mi: Any, room: OpenRoom, rng: np.random.Generator) -> dict[str, Any]:
    """A bright ceiling and a window behind whoever takes the picture."""
    x, y = room.size
    warm = np.array([1.0, rng.uniform(0.82, 0.95), rng.uniform(0.65, 0.85)])
    day = np.array([rng.uniform(0.85, 1.0), 0.95, 1.0])
    lamp = [rng.uniform(0.45, 0.55) * x, rng.uniform(0.45, 0.55) * y, HEIGHT - 0.03]
    window = [rng.uniform(0.3, 0.7) * x, 0.02, 1.6]
    turned = mi.ScalarTransform4f
    return {
        "lamp": {
            "type": "rectangle",
            "to_world": turned().translate(lamp).rotate([1, 0, 0], 180).scale([0.4 * x, 0.4 * y, 1]),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": (LAMP * rng.uniform(0.4, 1) * warm).tolist()},
            },
        },
        "window": {
            "type": "rectangle",
            "to_world": turned().translate(window).rotate([1, 0, 0], -90).scale([0.9, 0.6, 1]),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": (WINDOW * rng.uniform(0.3, 1) * day).tolist()},
            },
        },
    }


def _paper_room(half: str, packs: Path, rng: np.random.Generator) -> list[dict[str, Any]]:
    """What floor, ceiling and the four walls look like."""
    floor, wall = str(rng.choice(FLOORS[half])), str(rng.choice(WALLS[half]))
    paint = PAINTS[int(rng.integers(len(PAINTS)))]
    on_floor = _tile_picture(np.array(texture(packs, half, floor)), TILE["floor"])
    on_walls = _tile_picture(np.array(texture(packs, half, wall)), TILE["wall"]) if wall else _matt(paint)
    return [on_floor, _matt((0.88, 0.88, 0.86)), *[on_walls] * 4]


def _linear(color: NDArray[Any] | tuple[float, float, float]) -> list[float]:
    values = np.asarray(color, dtype=float)
    return np.where(values < 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).tolist()


def _matt(color: tuple[float, float, float]) -> dict[str, Any]:
    inner = {"type": "diffuse", "reflectance": {"type": "rgb", "value": _linear(np.clip(color, 0.02, 0.9))}}
    return {"type": "twosided", "bsdf": inner}


def _bitmap(picture: NDArray[np.uint8], scale: float = 1.0) -> dict[str, Any]:
    import mitsuba as mi

    turned = mi.ScalarTransform3f().scale([1 / scale, 1 / scale])
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(picture)), "to_uv": turned}


def _tile_picture(picture: NDArray[np.uint8], metres: float) -> dict[str, Any]:
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": _bitmap(picture[..., :3], metres)}}


def _make_material(mi: Any, surface: PlacedMesh) -> dict[str, Any]:
    part = surface.part
    if surface.kind == MIRROR:
        return {"type": "twosided", "bsdf": {"type": "conductor", "material": "Ag"}}
    if surface.kind == GLASS:
        return {"type": "thindielectric"}
    color: dict[str, Any] = {"type": "rgb", "value": _linear(np.clip(part.color, 0.02, 0.92))}
    if part.picture is not None and part.uv is not None:
        color = _bitmap(part.picture[..., :3])
    inner = {"type": "principled", "base_color": color, "roughness": 0.55, "specular": 0.35}
    bsdf: dict[str, Any] = {"type": "twosided", "bsdf": inner}
    if part.picture is not None and part.uv is not None and part.picture.shape[2] == 4:
        alpha = part.picture[..., 3:]
        if alpha.min() < 128:
            return {"type": "mask", "opacity": _bitmap(alpha) | {"raw": True}, "bsdf": bsdf}
    if part.opacity < 1:
        return {"type": "mask", "opacity": float(max(part.opacity, 0.3)), "bsdf": bsdf}
    return bsdf


def _mesh(mi: Any, part: PaintedMesh, bsdf: dict[str, Any], name: str) -> Any:
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(bsdf)
    smooth, textured = part.normals is not None, part.uv is not None
    mesh = mi.Mesh(name, len(part.vertices), len(part.faces), properties, smooth, textured)
    values = mi.traverse(mesh)
    values["vertex_positions"] = part.vertices.astype(np.float32).ravel()
    values["faces"] = part.faces.astype(np.uint32).ravel()
    if part.normals is not None:
        values["vertex_normals"] = np.nan_to_num(part.normals).astype(np.float32).ravel()
    if part.uv is not None:
        values["vertex_texcoords"] = np.nan_to_num(part.uv).astype(np.float32).ravel()
    values.update()
    return mesh
