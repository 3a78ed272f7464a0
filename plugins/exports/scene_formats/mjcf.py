"""A folder for MuJoCo: scene.xml with meshes and textures beside it. The world is the floor frame, z up."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from roomkin.plugins.mujoco.mjcf_writer import TOUCHED, ModelWriter, document, text
from roomkin.stages.contracts.generated import GAMMA
from roomkin.stages.generation.scene_file import CAMERA, ExportedScene
from roomkin.stages.geometry.frames import OPENGL, quaternion_from_matrix, yaw_quaternion


def write(room: ExportedScene, out: Path) -> None:
    """Write the folder `out`. Joints are at their lower limits; what is not fixed to a wall has a free joint."""
    with document(out, f"{room.scene.scene}_rank_{room.scene.rank}") as (root, writer):
        visual = ET.SubElement(root, "visual")
        ET.SubElement(visual, "headlight", ambient="0.42 0.42 0.44", diffuse="0 0 0", specular="0 0 0")
        ET.SubElement(visual, "global", offwidth=str(room.scene.width), offheight=str(room.scene.height))
        _furnish(writer, ET.SubElement(root, "worldbody"), room)


def _furnish(writer: ModelWriter, world: ET.Element, room: ExportedScene) -> None:
    """Light, camera, floor, walls and all bodies."""
    points = np.concatenate([body.corners for body in room.bodies])
    away = np.linalg.norm(np.ptp(points, axis=0)) / np.linalg.norm(room.light)
    position = points.mean(axis=0) - away * room.light
    light = {"name": "key", "type": "directional", "pos": text(position), "dir": text(room.light)}
    ET.SubElement(world, "light", light, diffuse="0.8 0.78 0.74", castshadow="true")
    _camera(world, room)
    for block in room.blocks:
        color = [*(value ** (1 / GAMMA) for value in block.color), 1.0]
        box = {"name": block.name, "type": "box", "size": text(np.array(block.size) / 2), "rgba": text(color)}
        place = {"pos": text(block.center), "quat": text(yaw_quaternion(block.yaw))}
        ET.SubElement(world, "geom", box | place, friction=TOUCHED)
    for body in room.bodies:
        writer.model(world, body.id, body.model, body.pose, body.fixed)


def _camera(world: ET.Element, room: ExportedScene) -> None:
    generated, pose = room.scene, room.world_from_camera
    k = np.array(generated.intrinsics)
    width, height = generated.width, generated.height
    # MuJoCo counts from the middle of the picture to the principal point, leftwards and upwards
    middle = [(width - 1) / 2 - k[0, 2], (height - 1) / 2 - k[1, 2]]
    ET.SubElement(
        world, "camera", name=CAMERA, pos=text(pose[:3, 3]),
        quat=text(quaternion_from_matrix(pose[:3, :3] @ OPENGL[:3, :3])), resolution=f"{width} {height}",
        focalpixel=text([k[0, 0], k[1, 1]]), principalpixel=text(middle),
        sensorsize=text([width * 1e-5, height * 1e-5]),
    )  # fmt: skip
