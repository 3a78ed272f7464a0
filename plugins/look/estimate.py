"""The look of a room's picture: light by its shadows, colors such that a rendering has those of the picture."""

from collections.abc import Mapping, Sequence

import numpy as np
import sapien
import trimesh
from numpy.typing import NDArray
from trimesh import Trimesh

from plugins.look.surfaces import (
    MIN_CORRELATION,
    USUAL_LIGHT,
    Seen,
    estimate_light,
    find_bounds,
    find_grid,
    find_surfaces,
)
from plugins.pictures.painting import furnish
from stages.contracts.generated import GeneratedScene
from stages.contracts.look import GAMMA, Look, Surface
from stages.contracts.objects import Objects
from stages.generation.models import read_collisions
from stages.generation.placed import Placed
from stages.simulation.rendering import RenderCamera, instance_id


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
    scene: sapien.Scene, surfaces: Sequence[Surface], seen: Mapping[str, Seen], objects: Objects
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
