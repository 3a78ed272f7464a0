"""A folder for MuJoCo: scene.xml with meshes and textures beside it. The world is the floor frame, z up."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from stages.articulated import mesh_writer
from stages.articulated.asset_folder import atomic_folder
from stages.articulated.model import JointModel, Link, Matrix
from stages.articulated.urdf_writer import DAMPING, FRICTION
from stages.contracts.look import GAMMA
from stages.contracts.system import sync
from stages.generation.exports import CAMERA, OPENGL, Body, Room
from stages.generation.exports.surfaces import ColouredMesh, surfaces, write_obj
from stages.geometry.frames import quaternion_from_matrix, yaw_quaternion
from stages.simulation.loading import SURFACE_FRICTION


def write(room: Room, out: Path) -> None:
    """Write the folder `out`. Joints are at their lower limits; what is not fixed to a wall has a free joint."""
    with _document(out, f"{room.scene.scene}_rank_{room.scene.rank}") as (root, writer):
        visual = ET.SubElement(root, "visual")
        ET.SubElement(visual, "headlight", ambient="0.42 0.42 0.44", diffuse="0 0 0", specular="0 0 0")
        ET.SubElement(visual, "global", offwidth=str(room.scene.width), offheight=str(room.scene.height))
        writer.room(ET.SubElement(root, "worldbody"), room)


def write_model(body: Body, out: Path) -> None:
    """Write the folder `out` with one model alone, at its pose."""
    with _document(out, body.id) as (root, writer):
        writer.body(ET.SubElement(root, "worldbody"), body)


@contextmanager
def _document(out: Path, name: str) -> Iterator[tuple[ET.Element, "_Writer"]]:
    """The root element of scene.xml, and what writes into it; both are in `out` when the block ends."""
    with atomic_folder(out) as folder:
        for inside in ("meshes", "textures"):
            (folder / inside).mkdir()
        root = ET.Element("mujoco", model=name)
        ET.SubElement(root, "compiler", angle="radian", meshdir="meshes", texturedir="textures", balanceinertia="true")
        ET.SubElement(root, "option", timestep="0.002", integrator="implicitfast")
        defaults = ET.SubElement(root, "default")
        seen = ET.SubElement(defaults, "default", {"class": "visual"})
        ET.SubElement(seen, "geom", type="mesh", group="2", contype="0", conaffinity="0", mass="0")
        touched = ET.SubElement(defaults, "default", {"class": "collision"})
        ET.SubElement(touched, "geom", group="3", mass="0", friction=f"{SURFACE_FRICTION} 0.005 0.0001")
        yield root, _Writer(folder, ET.SubElement(root, "asset"), ET.SubElement(root, "contact"))
        ET.indent(root)
        (folder / "scene.xml").write_text(ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
        sync(folder)


class _Writer:
    """Writes elements, with the meshes that they name."""

    def __init__(self, folder: Path, assets: ET.Element, contacts: ET.Element) -> None:
        self.folder, self.assets, self.contacts = folder, assets, contacts
        self.numbers = count()
        self.textures: dict[tuple[tuple[int, int], bytes], str] = {}

    def room(self, world: ET.Element, room: Room) -> None:
        """Light, camera, floor, walls and all bodies."""
        points = np.concatenate([body.corners for body in room.bodies])
        away = np.linalg.norm(np.ptp(points, axis=0)) / np.linalg.norm(room.light)
        position = points.mean(axis=0) - away * room.light
        light = {"name": "key", "type": "directional", "pos": _text(position), "dir": _text(room.light)}
        ET.SubElement(world, "light", light, diffuse="0.8 0.78 0.74", castshadow="true")
        self._camera(world, room)
        for block in room.blocks:
            colour = [*(value ** (1 / GAMMA) for value in block.colour), 1.0]
            box = {"name": block.name, "type": "box", "size": _text(np.array(block.size) / 2), "rgba": _text(colour)}
            place = {"pos": _text(block.center), "quat": _text(yaw_quaternion(block.yaw))}
            ET.SubElement(world, "geom", box | place, friction=f"{SURFACE_FRICTION} 0.005 0.0001")
        for body in room.bodies:
            self.body(world, body)

    def _camera(self, world: ET.Element, room: Room) -> None:
        made, pose = room.scene, room.world_from_camera
        k = np.array(made.intrinsics)
        width, height = made.width, made.height
        # MuJoCo counts from the middle of the picture to the principal point, leftwards and upwards
        middle = [(width - 1) / 2 - k[0, 2], (height - 1) / 2 - k[1, 2]]
        ET.SubElement(
            world,
            "camera",
            name=CAMERA,
            pos=_text(pose[:3, 3]),
            quat=_text(quaternion_from_matrix(pose[:3, :3] @ OPENGL[:3, :3])),
            resolution=f"{width} {height}",
            focalpixel=_text([k[0, 0], k[1, 1]]),
            principalpixel=_text(middle),
            sensorsize=_text([width * 1e-5, height * 1e-5]),
        )

    def body(self, world: ET.Element, body: Body) -> None:
        """The links of a model, with what is seen of them and what collides."""
        children = {joint.child: joint for joint in body.model.joints}
        elements: dict[str, ET.Element] = {}
        for name in [body.model.root, *children]:
            joint = children.get(name)
            parent = world if joint is None else elements[joint.parent]
            pose = body.pose if joint is None else joint.origin @ joint.motion(joint.lower)
            element = ET.SubElement(parent, "body", {"name": f"{body.id}/{name}"} | _place(pose))
            elements[name] = element
            if joint is None and not body.fixed:
                ET.SubElement(element, "freejoint", name=body.id)
            if joint is not None:
                self._joint(element, body, joint)
            self._link(element, body, body.model.links[name])

    def _joint(self, element: ET.Element, body: Body, joint: JointModel) -> None:
        """MuJoCo lets a moving link touch its parent if that is fixed to the world: it must be told not to."""
        parent = f"{body.id}/{joint.parent}"
        ET.SubElement(self.contacts, "exclude", body1=parent, body2=f"{body.id}/{joint.child}")
        if joint.type == "fixed":
            return
        hinge = joint.type == "revolute"
        ET.SubElement(
            element,
            "joint",
            name=f"{body.id}/{joint.name}",
            type="hinge" if hinge else "slide",
            axis=_text(joint.axis),
            range=_text([joint.lower, joint.upper]),
            limited="true",
            ref=_text([joint.lower]),
            damping=_text([DAMPING]),
            frictionloss=_text([FRICTION]),
        )

    def _link(self, element: ET.Element, body: Body, link: Link) -> None:
        i = link.inertia
        tensor = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        ET.SubElement(element, "inertial", pos=_text(link.center), mass=_text([link.mass]), fullinertia=_text(tensor))
        for surface in surfaces(link):
            self._seen(element, f"{body.id}_{next(self.numbers)}", surface)
        for piece in link.collisions:
            if mesh_writer.is_box(piece):
                box = {"pos": _text(piece.bounds.mean(axis=0)), "size": _text(piece.extents / 2)}
                ET.SubElement(element, "geom", {"class": "collision", "type": "box"} | box)
                continue
            name = f"{body.id}_hull_{next(self.numbers)}"
            hull = mesh_writer.Surface(np.asarray(piece.vertices), np.asarray(piece.faces))
            mesh_writer.write_obj(self.folder / "meshes" / f"{name}.obj", [hull])
            ET.SubElement(self.assets, "mesh", name=name, file=f"{name}.obj", inertia="shell")
            ET.SubElement(element, "geom", {"class": "collision", "type": "mesh", "mesh": name})

    def _seen(self, element: ET.Element, name: str, surface: ColouredMesh) -> None:
        write_obj(surface, self.folder / "meshes" / f"{name}.obj")
        ET.SubElement(self.assets, "mesh", name=name, file=f"{name}.obj", inertia="shell")
        looks = {"name": name, "rgba": _text(surface.shown_colour), "specular": "0.1", "shininess": "0.1"}
        if surface.image is not None:
            looks["texture"] = self._texture(surface.image)
        ET.SubElement(self.assets, "material", looks)
        ET.SubElement(element, "geom", {"class": "visual", "mesh": name, "material": name})

    def _texture(self, image: Image.Image) -> str:
        """Name of a texture; images that are the same share a file."""
        content = image.convert("RGB")
        key = content.size, content.tobytes()
        if key not in self.textures:
            name = self.textures[key] = f"texture_{len(self.textures)}"
            content.save(self.folder / "textures" / f"{name}.png")
            ET.SubElement(self.assets, "texture", name=name, type="2d", file=f"{name}.png")
        return self.textures[key]


def _place(pose: Matrix) -> dict[str, str]:
    return {"pos": _text(pose[:3, 3]), "quat": _text(quaternion_from_matrix(pose[:3, :3]))}


def _text(values: Iterable[float] | ArrayLike) -> str:
    return " ".join(f"{value + 0.0:.8g}" for value in np.asarray(values, dtype=float).ravel())
