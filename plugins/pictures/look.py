"""A scene with floor, walls and light as its picture has them, and its pictures for people."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import sapien
import trimesh
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from trimesh import Trimesh

from roomkin.stages.contracts.generated import GAMMA, ROOM_LIGHT, GeneratedScene, Look, Surface
from roomkin.stages.contracts.objects import Objects
from roomkin.stages.contracts.types import LARGEST
from roomkin.stages.generation.placed import Placed, read_collisions
from roomkin.stages.generation.settling import load_items
from roomkin.stages.geometry.boxes import corners
from roomkin.stages.geometry.frames import SAMPLED, back_project, scale_intrinsics, transform_points
from roomkin.stages.geometry.masks import MIN_PIXELS
from roomkin.stages.simulation.rendering import RenderCamera, instance_id, make_scene
from roomkin.stages.simulation.room import BEYOND, WALL_HEIGHT, add_backdrop


def furnish(generated: GeneratedScene, items: list[Placed], look: Look) -> sapien.Scene:
    """The scene in its look, to be rendered: floor, walls, furniture, and a light whose shadows reach all of it."""
    points = np.concatenate([corners(item.box) for item in items])
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - center, axis=1).max()) + BEYOND
    scene = make_scene(light=look.light, shaded=(center.tolist(), radius))
    camera = np.array(generated.floor_from_camera)[:3, 3]
    add_backdrop(scene, [item.box for item in items], generated.walls, camera, look)
    load_items(scene, items)
    return scene


SMOOTHING = 2  # rendered so many times larger and averaged; chosen


def draw_preview(scene: sapien.Scene, generated: GeneratedScene, width: int) -> NDArray[np.uint8]:
    """The scene as the input camera sees it, (H, width, 3); its world is the floor frame."""
    factor = SMOOTHING * width / generated.width
    height = round(generated.height * width / generated.width)
    intrinsics = scale_intrinsics(np.array(generated.intrinsics), factor, factor)
    picture = RenderCamera(scene, intrinsics, SMOOTHING * width, SMOOTHING * height).render(generated.floor_from_camera)
    return np.asarray(Image.fromarray(picture.rgb).resize((width, height), Image.Resampling.BOX))


def resize_to(rgb: NDArray[np.uint8], width: int) -> NDArray[np.uint8]:
    """A picture (H, W, 3), resized to a width."""
    size = width, round(rgb.shape[0] * width / rgb.shape[1])
    return np.asarray(Image.fromarray(rgb).resize(size, Image.Resampling.LANCZOS))


def draw_side_by_side(pictures: list[tuple[str, NDArray[np.uint8]]]) -> Image.Image:
    """Pictures of one size with their titles above, three to a row."""
    height, width = pictures[0][1].shape[:2]
    columns, title_height, gap = min(3, len(pictures)), width // 12, width // 100
    rows = -(-len(pictures) // columns)
    cell_width, cell_height = width + gap, height + title_height + gap
    sheet = Image.new("RGB", (columns * cell_width - gap, rows * cell_height - gap), "white")
    canvas, font = ImageDraw.Draw(sheet), ImageFont.load_default(title_height * 2 / 3)
    for index, (title, picture) in enumerate(pictures):
        x, y = index % columns * cell_width, index // columns * cell_height
        canvas.text((x + width / 2, y + title_height / 2), title, fill="black", font=font, anchor="mm")
        sheet.paste(Image.fromarray(picture).resize((width, height)), (x, y + title_height))
    return sheet


Array = NDArray[np.float64]
Pixels = NDArray[np.int64]
GRID_COLUMNS = 200  # the picture is looked at on a grid of so many columns, or its own; chosen
OFF_SURFACE = 0.05  # metres, at 0 m and more for each: how far the depth of a pixel may miss its surface; chosen
TRIMMED = 0.002  # share of a surface's pixels beyond its bounds; chosen
BEYOND_BORDER = 0.3  # metres that a surface goes on at the picture's border; chosen
AZIMUTHS, ELEVATIONS = np.radians(np.arange(0, 360, 15)), np.radians(np.arange(25, 76, 10))  # of light; then half steps
DARKEST_LOG = 0.5  # of the logarithm of brightness, more counts no more; chosen
USUAL_LIGHT: Array = np.array(ROOM_LIGHT) / np.linalg.norm(ROOM_LIGHT)  # where the picture says nothing
MIN_CORRELATION = 0.25  # below it the picture shows no shadows to go by; chosen


@dataclass(frozen=True)
class SeenPixels:
    """The pixels of the grid at which a surface is seen: row and column in it, place (N, 3), color (N, 3) of 0 to 1.

    `normal` faces the camera; `open_above`: the surface goes on beyond the picture's upper border.
    """

    normal: Array
    rows: Pixels
    columns: Pixels
    points: Array
    rgb: Array
    open_above: bool


def find_grid(objects: Objects) -> tuple[int, Array]:
    """Step of the grid in pixels, and the intrinsics (3, 3) of the picture that has every such pixel alone."""
    step = max(1, round(objects.width / GRID_COLUMNS))
    return step, np.diag([1 / step, 1 / step, 1.0]) @ np.array(objects.intrinsics)


def find_surfaces(
    rgb: NDArray[np.uint8], masks: NDArray[np.uint16], depth: NDArray[np.float32] | None, objects: Objects
) -> dict[str, SeenPixels]:
    """Visible floor and walls: pixels of no object whose ray meets the plane first, at about their depth.

    Args:
        rgb: the picture (H, W, 3).
        masks: of the objects (H, W), 0: none.
        depth: metres along the optical axis (H, W), 0: unknown; None: the nearest plane is taken to be seen.
        objects: camera, floor frame and walls.
    """
    step, intrinsics = find_grid(objects)
    rgb, free = rgb[::step, ::step], masks[::step, ::step] == 0
    world_from_camera = np.array(objects.floor_from_camera)
    camera = world_from_camera[:3, 3]
    rays = transform_points(world_from_camera, back_project(np.ones(free.shape), intrinsics)) - camera
    planes = [("floor", np.array([0.0, 0, 1]), 0.0)]
    planes += [(wall.id, np.array(wall.normal), wall.offset) for wall in objects.walls]
    far = np.stack([_distance(rays, camera, normal, offset) for _, normal, offset in planes])
    first, nearest = far.argmin(axis=0), far.min(axis=0)  # along the optical axis
    free &= nearest < LARGEST
    if depth is not None:
        depth = depth[::step, ::step]
        free &= (depth > 0) & (np.abs(depth - nearest) < OFF_SURFACE * (1 + nearest))
    found = {}
    for index, (name, normal, _) in enumerate(planes):
        rows, columns = np.nonzero(free & (first == index))
        if len(rows) >= MIN_PIXELS:
            points = camera + rays[rows, columns] * nearest[rows, columns, None]
            found[name] = SeenPixels(normal, rows, columns, points, rgb[rows, columns] / 255.0, bool(rows.min() < 2))
    return found


def _distance(rays: Array, camera: Array, normal: Array, offset: float) -> Array:
    """How far along the optical axis the rays (H, W, 3) meet the front of a plane; infinite where they do not."""
    height, falling = camera @ normal - offset, -(rays @ normal)
    return np.where((falling > 1e-6) & (height > 0), height / np.maximum(falling, 1e-6), np.inf)


def find_bounds(name: str, seen: SeenPixels) -> tuple[tuple[float, float], tuple[float, float]]:
    """Bounds of a surface from what is seen of it: x and y of the floor; along the tangent of a wall, and in height."""
    tangent = np.array([-seen.normal[1], seen.normal[0], 0.0])
    along = seen.points[:, :2] if name == "floor" else np.column_stack([seen.points @ tangent, seen.points[:, 2]])
    low, high = np.quantile(along, [TRIMMED, 1 - TRIMMED], axis=0) + np.array([[-BEYOND_BORDER], [BEYOND_BORDER]])
    if name != "floor":
        low[1], high[1] = 0.0, max(high[1], WALL_HEIGHT) if seen.open_above else high[1] - BEYOND_BORDER
    (a, b), (c, d) = low.round(3).tolist(), high.round(3).tolist()
    return (a, b), (c, d)


def estimate_light(seen: Mapping[str, SeenPixels], furniture: Trimesh) -> tuple[Array, float]:
    """Unit direction in which the light shines, and how well its shadows agree with the picture.

    Of all directions that come through no wall, the one for which the places that the furniture keeps from the light
    are the darkest of their surface: the correlation over pixels of floor and walls of being in shadow with the
    logarithm of brightness below the surface's median. Texture of a floor lowers it, but for every direction.
    """
    if not seen:
        return USUAL_LIGHT, 0.0
    share = min(1.0, SAMPLED / sum(len(one.points) for one in seen.values()))
    origins, dark = [], []
    for one in seen.values():
        some = np.linspace(0, len(one.points) - 1, max(2, round(share * len(one.points)))).astype(int)
        brightness = np.log(one.rgb[some].mean(axis=1) + 0.02)
        origins.append(one.points[some] + 0.01 * one.normal)
        dark.append(np.clip(np.median(brightness) - brightness, -DARKEST_LOG, DARKEST_LOG))
    walls = [one.normal for name, one in seen.items() if name != "floor"]

    def score_direction(direction: Array) -> float:
        if any(direction @ normal > 0 for normal in walls):
            return -1.0
        all_origins = np.concatenate(origins)
        rays = np.broadcast_to(-direction, all_origins.shape)
        shadow = furniture.ray.intersects_any(all_origins, rays).astype(float)
        cuts = np.cumsum([len(points) for points in origins])[:-1]
        parts = [(s - s.mean(), d - d.mean()) for s, d in zip(np.split(shadow, cuts), dark, strict=True)]
        s, d = (np.concatenate(values) for values in zip(*parts, strict=True))
        return float(s @ d / max(np.sqrt((s @ s) * (d @ d)), 1e-9))

    def find_best(angles: list[tuple[float, float]]) -> tuple[float, float, float]:
        return max((score_direction(to_direction(*each)), *each) for each in angles)

    _, azimuth, elevation = find_best(list(product(AZIMUTHS, ELEVATIONS)))
    half_a, half_e = ((grid[1] - grid[0]) / 2 for grid in (AZIMUTHS, ELEVATIONS))
    finer = product((-half_a, 0, half_a), (-half_e, 0, half_e))
    found, *angles = find_best([(azimuth + a, elevation + b) for a, b in finer])
    return to_direction(*angles), found


def to_direction(azimuth: float, elevation: float) -> Array:
    """Unit direction of light that shines towards an azimuth from so far above the horizon."""
    return np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), -np.sin(elevation)])


def estimate_look(
    objects: Objects,
    pictures: tuple[NDArray[np.uint8], NDArray[np.uint16], NDArray[np.float32] | None],
    generated: GeneratedScene,
    items: list[Placed],
) -> Look:
    """The look of a picture; one scene that was made of it says where furniture stands.

    Args:
        pictures: colors, masks and depth as `find_surfaces` takes them.
    """
    seen = find_surfaces(*pictures, objects)
    direction, correlation = estimate_light(seen, merge_meshes(items))
    found = correlation >= MIN_CORRELATION
    light = direction if found else USUAL_LIGHT
    bounds = {name: find_bounds(name, one) for name, one in seen.items()}
    surfaces = [Surface(id=name, colour=(0.5, 0.5, 0.5), low=a, high=b) for name, (a, b) in bounds.items()]
    look = Look(
        light=(round(light[0], 6), round(light[1], 6), round(light[2], 6)),
        light_from="shadows" if found else "default",
        shadow_correlation=round(correlation, 4),
        surfaces=surfaces,
    )
    scene = furnish(generated, items, look)
    for _ in range(2):  # each mends the colors of the one before
        look.surfaces = _adjust_colors(scene, look.surfaces, seen, objects)
    return look


def _adjust_colors(
    scene: sapien.Scene, surfaces: Sequence[Surface], seen: Mapping[str, SeenPixels], objects: Objects
) -> list[Surface]:
    """Surfaces in colors nearer to the picture's, by how far a rendering misses their medians; the scene has them."""
    step, intrinsics = find_grid(objects)
    camera = RenderCamera(scene, intrinsics, -(-objects.width // step), -(-objects.height // step))
    picture = camera.render(objects.floor_from_camera)
    camera.close()
    blocks = {entity.name: entity for entity in scene.entities}
    mended = []
    for surface in surfaces:
        rows, columns = seen[surface.id].rows, seen[surface.id].columns
        block = blocks.get(surface.id)
        both = picture.segmentation[rows, columns] == (instance_id(block) if block else -1)
        if block is not None and both.any():
            wanted = np.median(seen[surface.id].rgb[both], axis=0)
            drawn = np.median(picture.rgb[rows[both], columns[both]] / 255.0, axis=0)
            color = np.array(surface.colour) * (wanted / np.maximum(drawn, 0.01)) ** GAMMA
            r, g, b = np.clip(color, 0.02, 1.0).round(4).tolist()
            surface = surface.model_copy(update={"colour": (r, g, b)})
            material = block.find_component_by_type(sapien.render.RenderBodyComponent).render_shapes[0].material
            material.base_color = [r, g, b, 1.0]
        mended.append(surface)
    return mended


def merge_meshes(items: list[Placed]) -> Trimesh:
    """All that collides in a scene, in its place, as one mesh."""
    meshes = [
        Trimesh(piece.vertices, piece.faces, process=False).apply_transform(item.pose)
        for item in items
        for piece in read_collisions(item.folder)
    ]
    whole = trimesh.util.concatenate(meshes)
    assert isinstance(whole, Trimesh)
    return whole
