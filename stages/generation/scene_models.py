"""The models of a generated scene in their places, as writers of other formats read them."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.articulated.mesh_writer import split_sharp_edges
from roomkin.stages.articulated.model import JointModel, RobotModel, Visual, link_frames
from roomkin.stages.articulated.surfaces import ColoredMesh
from roomkin.stages.contracts import Asset, GeneratedScene
from roomkin.stages.contracts.generated import ROOM_LIGHT, Look
from roomkin.stages.generation.placed import Placed
from roomkin.stages.geometry.frames import transform_points
from roomkin.stages.simulation.room import ColoredBlock, make_backdrop

Matrix = NDArray[np.float64]
CAMERA = "input_camera"


@dataclass(frozen=True)
class Body:
    """A model in its place. `folder`: its files at its size; `pose`: world_from_root (4, 4); not `fixed`: is free."""

    id: str
    label: str
    asset: Asset
    folder: Path
    model: RobotModel
    pose: Matrix
    fixed: bool

    @property
    def frames(self) -> dict[str, Matrix]:
        """root_from_link (4, 4) of every link, closed."""
        return link_frames(self.model)

    @property
    def corners(self) -> Matrix:
        """Of the closed box (8, 3), in the world."""
        low, high = self.asset.box_min, self.asset.box_max
        return transform_points(self.pose, np.array(list(product(*zip(low, high, strict=True)))))

    @property
    def moving(self) -> list[JointModel]:
        """Joints that are not fixed."""
        return [joint for joint in self.model.joints if joint.type != "fixed"]


@dataclass(frozen=True)
class ExportedScene:
    """A scene to export. World: the floor frame, z up, metres. `blocks`: floor and walls; `light`: its direction."""

    scene: GeneratedScene
    bodies: list[Body]
    blocks: list[ColoredBlock]
    light: Matrix

    @property
    def world_from_camera(self) -> Matrix:
        """Of the input picture (4, 4), OpenCV axes."""
        return np.array(self.scene.floor_from_camera)


def room_of(generated: GeneratedScene, items: list[Placed], look: Look | None) -> ExportedScene:
    """A scene with the models of its items, which are at their sizes."""
    bodies = [
        Body(item.id, item.label, item.asset, item.folder, read_model(item.folder), item.pose, item.held)
        for item in items
    ]
    camera = np.array(generated.floor_from_camera)[:3, 3]
    blocks = make_backdrop([item.box for item in items], generated.walls, camera, look)
    return ExportedScene(generated, bodies, blocks, np.array(look.light if look else ROOM_LIGHT))


def surface_of(block: ColoredBlock) -> ColoredMesh:
    """A block of the backdrop, about its own center."""
    generated = split_sharp_edges(Visual(trimesh.creation.box(block.size), flat=True))
    assert generated.normals is not None
    return ColoredMesh(generated.vertices, generated.faces, generated.normals, (*block.color, 1.0))
