"""A folder of URDFs: scene.urdf is the whole room, models/<id>/ one object, scene.json says where each stands."""

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh

from stages.articulated.asset_folder import atomic_folder
from stages.articulated.model import JointModel, Link, RobotModel, Visual
from stages.articulated.urdf_writer import write_urdf
from stages.generation.exports import CAMERA, Body, Room
from stages.generation.exports.surfaces import GAMMA
from stages.geometry.frames import quaternion_from_matrix, rigid, yaw_matrix

WORLD = "world"
LIGHTEST = 1e-3  # kg, of a link that nobody weighs


def write(room: Room, out: Path) -> None:
    """Write the folder `out`. Free objects hang on the world by joints of type `floating`."""
    with atomic_folder(out) as folder:
        for body in room.bodies:
            write_urdf(_as_shown(body.model), folder / "models" / body.id)
        write_urdf(_whole(room), folder)
        (folder / "model.urdf").rename(folder / "scene.urdf")
        _free(folder / "scene.urdf", {_link(body, body.model.root) for body in room.bodies if not body.fixed})
        placed = [
            {
                "id": body.id,
                "urdf": f"models/{body.id}/model.urdf",
                "label": body.label,
                "asset": body.asset.id,
                "category": body.asset.category,
                "fixed": body.fixed,
                "position": body.pose[:3, 3].round(6).tolist(),
                "quaternion_wxyz": quaternion_from_matrix(body.pose[:3, :3]).round(6).tolist(),
            }
            for body in room.bodies
        ]
        camera = {"intrinsics": room.scene.intrinsics, "world_from_camera": room.scene.floor_from_camera}
        about = {"scene": room.scene.scene, "rank": room.scene.rank, "camera": camera, "objects": placed}
        (folder / "scene.json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


def _whole(room: Room) -> RobotModel:
    """Everything as one tree about a link `world`, which carries floor and walls."""
    visuals, collisions = [], []
    for block in room.blocks:
        box = trimesh.creation.box(block.size, transform=rigid(yaw_matrix(block.yaw), block.center))
        r, g, b = block.colour
        visuals.append(Visual(box, (r, g, b, 1.0), flat=True))
        collisions.append(box)
    links = {WORLD: Link(WORLD, visuals, collisions, 1.0, np.zeros(3), np.eye(3)), CAMERA: _massless(CAMERA)}
    joints = [JointModel(f"{CAMERA}_joint", "fixed", WORLD, CAMERA, room.world_from_camera)]
    for body in room.bodies:
        named = {name: _link(body, name) for name in body.model.links}
        links |= {named[name]: replace(link, name=named[name]) for name, link in body.model.links.items()}
        joints.append(JointModel(f"{body.id}__place", "fixed", WORLD, named[body.model.root], body.pose))
        joints += [
            replace(joint, name=f"{body.id}__{joint.name}", parent=named[joint.parent], child=named[joint.child])
            for joint in body.model.joints
        ]
    return _as_shown(RobotModel(f"{room.scene.scene}_rank_{room.scene.rank}", links, joints))


def _link(body: Body, name: str) -> str:
    return f"{body.id}__{name}"


def _massless(name: str) -> Link:
    return Link(name, [], [], LIGHTEST, np.zeros(3), np.eye(3) * 1e-6)


def _as_shown(model: RobotModel) -> RobotModel:
    """Colours as screens show them: viewers of URDF take them so, SAPIEN alone takes them as linear."""

    def shown(visual: Visual) -> Visual:
        if visual.colour is None:
            return visual
        r, g, b, a = visual.colour
        return replace(visual, colour=(r ** (1 / GAMMA), g ** (1 / GAMMA), b ** (1 / GAMMA), a))

    links = {
        name: replace(link, visuals=[shown(visual) for visual in link.visuals]) for name, link in model.links.items()
    }
    return replace(model, links=links)


def _free(path: Path, roots: set[str]) -> None:
    """Let the joints that hold these links be `floating`."""
    tree = ET.parse(path)
    for joint in tree.iter("joint"):
        child = joint.find("child")
        if child is not None and child.get("link") in roots:
            joint.set("type", "floating")
    tree.write(path, encoding="unicode")
