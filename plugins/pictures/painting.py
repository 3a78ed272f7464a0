"""A scene with floor, walls and light, to be rendered."""

import numpy as np
import sapien

from stages.contracts.generated import GeneratedScene
from stages.contracts.look import ROOM_LIGHT, Look
from stages.generation.placed import Placed
from stages.generation.settling import load_items
from stages.geometry.boxes import corners
from stages.simulation.backdrop import BEYOND, add_backdrop
from stages.simulation.rendering import make_scene


def make_usual_look() -> Look:
    """The look of a room whose picture nobody looked at: the usual light and colors."""
    x, y, z = (np.array(ROOM_LIGHT) / np.linalg.norm(ROOM_LIGHT)).round(6).tolist()
    return Look(light=(x, y, z), light_from="default", shadow_correlation=0.0, surfaces=[])


def furnish(generated: GeneratedScene, items: list[Placed], look: Look) -> sapien.Scene:
    """The scene in its look, to be rendered: floor, walls, furniture, and a light whose shadows reach all of it."""
    points = np.concatenate([corners(item.box) for item in items])
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - center, axis=1).max()) + BEYOND
    scene = make_scene(light=look.light, shaded=(center.tolist(), radius))
    add_backdrop(
        scene, [item.box for item in items], generated.walls, np.array(generated.floor_from_camera)[:3, 3], look
    )
    load_items(scene, items)
    return scene
