"""MuJoCo's MJCF: a folder with scene.xml, meshes and textures; a link is a body, with its joint, looks and hulls."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from roomkin.stages.articulated import mesh_writer
from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.articulated.mesh_writer import ColoredMesh, surfaces, write_colored_obj
from roomkin.stages.articulated.model import JointModel, Link, Matrix, RobotModel
from roomkin.stages.articulated.urdf_writer import DAMPING, FRICTION, SURFACE_FRICTION
from roomkin.stages.contracts.parts import PARTS
from roomkin.stages.contracts.system import sync
from roomkin.stages.geometry.frames import quaternion_from_matrix

TOUCHED = f"{SURFACE_FRICTION} 0.005 0.0001"  # friction: sliding, and MuJoCo's own of twisting and rolling


def write_model(model: RobotModel, name: str, out: Path) -> None:
    """Write the folder `out` with one model alone, fixed where the world's frame is."""
    with document(out, name) as (root, writer):
        writer.model(ET.SubElement(root, "worldbody"), name, model, np.eye(4), fixed=True)


@contextmanager
def document(out: Path, name: str) -> Iterator[tuple[ET.Element, "ModelWriter"]]:
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
        ET.SubElement(touched, "geom", group="3", mass="0", friction=TOUCHED)
        pairs = ET.Element("equality")
        yield root, ModelWriter(folder, ET.SubElement(root, "asset"), ET.SubElement(root, "contact"), pairs)
        if len(pairs):
            root.append(pairs)
        ET.indent(root)
        (folder / "scene.xml").write_text(ET.tostring(root, encoding="unicode") + "\n", encoding="utf-8")
        sync(folder)


class ModelWriter:
    """Writes models into a document, with the meshes and textures that they name."""

    def __init__(self, folder: Path, assets: ET.Element, contacts: ET.Element, pairs: ET.Element) -> None:
        self.folder, self.assets, self.contacts, self.pairs = folder, assets, contacts, pairs
        self.numbers = count()
        self.textures: dict[tuple[tuple[int, int], bytes], str] = {}

    def model(self, world: ET.Element, name: str, model: RobotModel, pose: Matrix, fixed: bool) -> None:
        """The links of a model at its pose (4, 4), with what is seen of them and what collides, joints at their lower
        limits; one that is not `fixed` has a free joint."""
        children = {joint.child: joint for joint in model.joints}
        elements: dict[str, ET.Element] = {}
        for link in [model.root, *children]:
            joint = children.get(link)
            parent = world if joint is None else elements[joint.parent]
            there = pose if joint is None else joint.origin @ joint.motion(joint.lower)
            element = ET.SubElement(parent, "body", {"name": f"{name}/{link}"} | _place(there))
            elements[link] = element
            if joint is None and not fixed:
                ET.SubElement(element, "freejoint", name=name)
            if joint is not None:
                self._joint(element, name, joint)
            self._link(element, name, model.links[link])

    def _joint(self, element: ET.Element, model: str, joint: JointModel) -> None:
        """MuJoCo checks contacts of a link with a parent that is fixed to the world: that pair must be excluded."""
        parent = f"{model}/{joint.parent}"
        ET.SubElement(self.contacts, "exclude", body1=parent, body2=f"{model}/{joint.child}")
        if joint.type == "fixed":
            return
        if joint.follows is not None:
            ET.SubElement(self.pairs, "joint", joint1=f"{model}/{joint.name}", joint2=f"{model}/{joint.follows}")
        hinge, stiffness = joint.type == "revolute", PARTS[joint.part_type].spring if joint.part_type else 0.0
        spring = {"stiffness": text([stiffness]), "springref": text([joint.lower])} if stiffness else {}
        ET.SubElement(
            element, "joint", spring, name=f"{model}/{joint.name}", type="hinge" if hinge else "slide",
            axis=text(joint.axis), range=text([joint.lower, joint.upper]), limited="true", ref=text([joint.lower]),
            damping=text([DAMPING]), frictionloss=text([FRICTION]),
        )  # fmt: skip

    def _link(self, element: ET.Element, model: str, link: Link) -> None:
        i = link.inertia
        tensor = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        ET.SubElement(element, "inertial", pos=text(link.center), mass=text([link.mass]), fullinertia=text(tensor))
        for surface in surfaces(link):
            self._add_visual(element, f"{model}_{next(self.numbers)}", surface)
        for piece in link.collisions:
            if mesh_writer.is_box(piece):
                box = {"pos": text(piece.bounds.mean(axis=0)), "size": text(piece.extents / 2)}
                ET.SubElement(element, "geom", {"class": "collision", "type": "box"} | box)
                continue
            name = f"{model}_hull_{next(self.numbers)}"
            hull = mesh_writer.TriangleSurface(np.asarray(piece.vertices), np.asarray(piece.faces))
            mesh_writer.write_obj(self.folder / "meshes" / f"{name}.obj", [hull])
            ET.SubElement(self.assets, "mesh", name=name, file=f"{name}.obj", inertia="shell")
            ET.SubElement(element, "geom", {"class": "collision", "type": "mesh", "mesh": name})

    def _add_visual(self, element: ET.Element, name: str, surface: ColoredMesh) -> None:
        write_colored_obj(surface, self.folder / "meshes" / f"{name}.obj")
        ET.SubElement(self.assets, "mesh", name=name, file=f"{name}.obj", inertia="shell")
        material = {"name": name, "rgba": text(surface.shown_color), "specular": "0.1", "shininess": "0.1"}
        if surface.image is not None:
            material["texture"] = self._texture(surface.image)
        ET.SubElement(self.assets, "material", material)
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
    return {"pos": text(pose[:3, 3]), "quat": text(quaternion_from_matrix(pose[:3, :3]))}


def text(values: Iterable[float] | ArrayLike) -> str:
    """Numbers as an attribute of MJCF."""
    return " ".join(f"{value + 0.0:.8g}" for value in np.asarray(values, dtype=float).ravel())
