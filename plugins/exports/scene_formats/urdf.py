"""A folder of URDFs: scene.urdf is the whole room, models/<id>/ one object, scene.json says where each stands."""

import json
import shutil
import xml.etree.ElementTree as ET
from copy import deepcopy
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.articulated.model import Matrix
from roomkin.stages.contracts.generated import GAMMA
from roomkin.stages.contracts.system import sync
from roomkin.stages.generation.scene_file import CAMERA, Body, ExportedScene
from roomkin.stages.geometry.frames import make_transform, quaternion_from_matrix, yaw_matrix
from roomkin.stages.simulation.room import ColoredBlock

WORLD = "world"
NAMES = {"link": "name", "joint": "name", "material": "name", "parent": "link", "child": "link", "mimic": "joint"}


def write(room: ExportedScene, out: Path) -> None:
    """Write the folder `out`. Free objects hang on the world by joints of type `floating`.

    Colors are as screens show them: viewers of URDF take them so, SAPIEN alone takes them as linear.
    """
    with atomic_folder(out) as folder:
        robot = ET.Element("robot", name=f"{room.scene.scene}_rank_{room.scene.rank}")
        world = ET.SubElement(robot, "link", name=WORLD)
        for block in room.blocks:
            _add_block(world, block)
        ET.SubElement(robot, "link", name=CAMERA)
        _add_place(robot, CAMERA, CAMERA, "fixed", room.world_from_camera)
        for body in room.bodies:
            model = folder / "models" / body.id
            shutil.copytree(body.folder, model, ignore=shutil.ignore_patterns("asset.json"))
            tree = ET.parse(model / body.asset.urdf)
            for color in tree.iter("color"):
                *rgb, alpha = (float(value) for value in color.get("rgba", "1 1 1 1").split())
                color.set("rgba", _text([*_encode_gamma(rgb), alpha]))
            tree.write(model / body.asset.urdf, encoding="unicode")
            _add_body(robot, body, tree.getroot())
        ET.indent(robot)
        (folder / "scene.urdf").write_text(ET.tostring(robot, encoding="unicode") + "\n", encoding="utf-8")
        (folder / "scene.json").write_text(json.dumps(_index(room), indent=1) + "\n", encoding="utf-8")
        sync(folder)


def _index(room: ExportedScene) -> dict[str, object]:
    placed = [
        {
            "id": body.id, "urdf": f"models/{body.id}/{body.asset.urdf}", "label": body.label, "asset": body.asset.id,
            "category": body.asset.category, "fixed": body.fixed, "position": body.pose[:3, 3].round(6).tolist(),
            "quaternion_wxyz": quaternion_from_matrix(body.pose[:3, :3]).round(6).tolist(),
        }
        for body in room.bodies
    ]  # fmt: skip
    camera = {"intrinsics": room.scene.intrinsics, "world_from_camera": room.scene.floor_from_camera}
    return {"scene": room.scene.scene, "rank": room.scene.rank, "camera": camera, "objects": placed}


def _add_block(world: ET.Element, block: ColoredBlock) -> None:
    for kind in ("visual", "collision"):
        element = ET.SubElement(world, kind, name=block.name)
        ET.SubElement(element, "origin", _origin(make_transform(yaw_matrix(block.yaw), block.center)))
        ET.SubElement(ET.SubElement(element, "geometry"), "box", size=_text(block.size))
        if kind == "visual":
            material = ET.SubElement(element, "material", name=block.name)
            ET.SubElement(material, "color", rgba=_text([*_encode_gamma(block.color), 1.0]))


def _add_place(robot: ET.Element, name: str, child: str, kind: str, pose: Matrix) -> None:
    joint = ET.SubElement(robot, "joint", name=f"{name}__place", type=kind)
    ET.SubElement(joint, "parent", link=WORLD)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", _origin(pose))


def _add_body(robot: ET.Element, body: Body, model: ET.Element) -> None:
    """The elements of the model's own URDF, their names headed by the object's, their meshes where it has them."""
    _add_place(robot, body.id, f"{body.id}__{body.model.root}", "fixed" if body.fixed else "floating", body.pose)
    for part in model:
        part = deepcopy(part)
        for element in part.iter():
            key = NAMES.get(element.tag, "")
            if key in element.attrib:
                element.set(key, f"{body.id}__{element.get(key)}")
            if "filename" in element.attrib:
                inside = (Path("models") / body.id / body.asset.urdf).parent / element.attrib["filename"]
                element.set("filename", inside.as_posix())
        robot.append(part)


def _encode_gamma(color: ArrayLike) -> list[float]:
    shown: list[float] = (np.asarray(color, dtype=float) ** (1 / GAMMA)).tolist()
    return shown


def _origin(pose: Matrix) -> dict[str, str]:
    return {"xyz": _text(pose[:3, 3]), "rpy": _text(Rotation.from_matrix(pose[:3, :3]).as_euler("xyz"))}


def _text(values: ArrayLike) -> str:
    return " ".join(f"{value + 0.0:.9g}" for value in np.asarray(values, dtype=float).ravel())
