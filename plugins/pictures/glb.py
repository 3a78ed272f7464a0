"""One binary glTF, y up: a node per object and link (with its joint in `extras`), floor, walls and the input camera."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from trimesh import Trimesh
from trimesh.exchange.gltf import export_glb

from roomkin.stages.articulated.mesh_writer import ColoredMesh, surfaces
from roomkin.stages.articulated.model import JointModel
from roomkin.stages.contracts import write_atomically
from roomkin.stages.generation.scene_file import CAMERA, Body, ExportedScene, surface_of
from roomkin.stages.geometry.frames import OPENGL, Y_UP, make_transform, yaw_matrix


def write(room: ExportedScene, out: Path, largest: int | None = None) -> None:
    """Write the GLB `out`; doors and drawers are closed.

    Args:
        largest: side of a texture in pixels; larger ones are made smaller, and all are WebP. Default: as they are.
    """
    points = np.concatenate([body.corners for body in room.bodies])
    low, high = points.min(axis=0), points.max(axis=0)
    scene = trimesh.Scene()
    scene.metadata = {  # for viewers
        "light": (Y_UP[:3, :3] @ room.light).round(6).tolist(),
        "center": (Y_UP[:3, :3] @ (low + high) / 2).round(4).tolist(),
        "radius": round(float(np.linalg.norm(high - low)) / 2, 4),
    }
    for block in room.blocks:
        pose = Y_UP @ make_transform(yaw_matrix(block.yaw), block.center)
        kind = "floor" if block.name == "floor" else "wall"
        mesh = _mesh(surface_of(block), largest)
        scene.add_geometry(mesh, node_name=block.name, geom_name=block.name, transform=pose, metadata={"surface": kind})
    for body in room.bodies:
        _add(scene, body, largest)
    view = room.scene
    fov = np.degrees(2 * np.arctan([view.width / view.intrinsics[0][0] / 2, view.height / view.intrinsics[1][1] / 2]))
    scene.camera = trimesh.scene.Camera(name=CAMERA, resolution=(view.width, view.height), fov=fov, z_far=100.0)
    scene.camera_transform = Y_UP @ room.world_from_camera @ OPENGL

    def set_aspect(tree: dict[str, Any]) -> None:
        """The camera's aspect is that of the picture (trimesh takes the ratio of the angles)."""
        tree["cameras"][0]["perspective"]["aspectRatio"] = view.width / view.height

    with write_atomically(out) as path:
        webp = largest is not None
        path.write_bytes(export_glb(scene, include_normals=True, extension_webp=webp, tree_postprocessor=set_aspect))


def _add(scene: trimesh.Scene, body: Body, largest: int | None) -> None:
    about = {"label": body.label, "asset": body.asset.id, "category": body.asset.category, "fixed": body.fixed}
    scene.graph.update(frame_to=body.id, frame_from="world", matrix=Y_UP @ body.pose, metadata=about)
    joints = {joint.child: joint for joint in body.model.joints}
    for name, link in body.model.links.items():
        node = f"{body.id}/{name}"
        scene.graph.update(
            frame_to=node,
            frame_from=body.id,
            matrix=body.frames[name],
            metadata={"mass": round(link.mass, 4)} | _describe_joint(joints.get(name)),
        )
        for index, surface in enumerate(surfaces(link)):
            part = f"{node}/{index}"
            scene.add_geometry(_mesh(surface, largest), node_name=part, geom_name=part, parent_node_name=node)


def _describe_joint(joint: JointModel | None) -> dict[str, Any]:
    """What a viewer needs to move a link; the node stands where the joint is at its lower limit."""
    if joint is None or joint.type == "fixed":
        return {}
    axis = joint.axis.round(6).tolist()
    return {"joint": joint.type, "axis": axis, "lower": round(joint.lower, 5), "upper": round(joint.upper, 5)}


def _mesh(surface: ColoredMesh, largest: int | None) -> Trimesh:
    image = surface.image
    if image is not None and largest is not None:
        image = image.convert("RGB")
        image.thumbnail((largest, largest))
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=np.array(surface.color), baseColorTexture=image, metallicFactor=0.0, roughnessFactor=0.8
    )
    visual = trimesh.visual.TextureVisuals(uv=surface.uv, material=material)
    return Trimesh(surface.vertices, surface.faces, vertex_normals=surface.normals, visual=visual, process=False)
