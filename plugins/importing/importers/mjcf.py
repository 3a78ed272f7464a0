"""MJCF, articulated or not, by MuJoCo's compiled model."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import mujoco
import numpy as np
import trimesh
from mujoco import mjtEq, mjtGeom, mjtJoint, mjtTexture, mjtTextureRole
from PIL import Image
from scipy.spatial.transform import Rotation
from trimesh import Trimesh

from roomkin.plugins.importing.hinges import mark_buttons
from roomkin.plugins.importing.importers import Importer
from roomkin.plugins.importing.mjcf_file import compile_model
from roomkin.stages.articulated.mesh_reader import convex_pieces
from roomkin.stages.articulated.model import RGBA, JointModel, Link, Matrix, RobotModel, Visual, transform_mesh
from roomkin.stages.articulated.urdf_reader import close_at_lower
from roomkin.stages.articulated.urdf_tree import MOST_LINKS, MOST_SHAPES, THIN
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import make_transform
from roomkin.stages.geometry.solids import MINIMUM_MASS, board_mass, box_around, box_inertia


def read_mjcf(path: Path, folder: Path) -> RobotModel:
    """Read a whole MJCF model: bodies as links, hinges and slides with limits as joints, all else fixed.

    Raises:
        InputError: names the file and what is wrong with it.
    """
    spec, model = compile_model(path, folder)
    if model.nbody > MOST_LINKS:
        raise InputError(path, f"has {model.nbody} bodies.", f"at most {MOST_LINKS}", code="E-MODEL-PARTS")
    if model.ngeom > MOST_SHAPES:
        raise InputError(path, f"has {model.ngeom} shapes.", f"at most {MOST_SHAPES}", code="E-MODEL-PARTS")
    if (free := int((model.jnt_type == mjtJoint.mjJNT_FREE).sum())) > 1:
        mend = "one file per model"
        raise InputError(path, f"holds {free} free bodies: a scene, not a model.", mend, code="E-MJCF-SCENE")
    reader = _Reader(spec, model)
    links, joints = reader.tree()
    if not any(link.visuals for link in links.values()):
        raise InputError(path, "shows nothing: no body has geometry.", code="E-MODEL-UNSEEN")
    sprung = [model.joint(number).name or f"joint_{number}" for number in np.flatnonzero(model.jnt_stiffness)]
    return mark_buttons(RobotModel(path.stem, links, joints, remarks=tuple(reader.remarks())), sprung)


USUAL_RGBA = (0.5, 0.5, 0.5, 1.0)  # of a geom that says nothing: MuJoCo paints it as its material is
PLAIN = 8  # of 255, by which the texels of a picture of one color differ
FREE = mjtJoint.mjJNT_FREE
UNSEEN = {mjtGeom.mjGEOM_HFIELD: "height fields", mjtGeom.mjGEOM_SDF: "signed distance fields"}


class _Reader:
    """Links and joints of a compiled model. A link's frame is its body's, moved to the point that its last joint turns
    about, as a URDF has it."""

    def __init__(self, spec: Any, model: Any) -> None:
        self.model = model
        self.pairs = self._pairs()
        self.masses = {body.id: mass for body in spec.bodies if (mass := _read_stated_mass(body)) is not None}
        collides = (model.geom_contype | model.geom_conaffinity) != 0
        own = (model.geom_rgba != USUAL_RGBA).any(axis=1) | (model.geom_matid < 0)  # its color beats its material's
        self.rgba = np.where(own[:, None], model.geom_rgba, model.mat_rgba[model.geom_matid] if model.nmat else 0.0)
        self.averaged = set[str]()
        shown = (mujoco.MjvOption().geomgroup[model.geom_group] > 0) & (self.rgba[:, 3] > 0)  # as a viewer shows
        self.collides, self.shown = collides, shown if shown.any() else np.ones_like(shown)
        # Models with looks of their own have them in other groups than what collides.
        own = self.shown & ~collides
        self.has_visuals = own.any() and not set(model.geom_group[own]) & set(model.geom_group[collides])

    def tree(self) -> tuple[dict[str, Link], list[JointModel]]:
        model, anchors = self.model, {0: np.zeros(3)}
        names = {body: model.body(body).name or f"body_{body}" for body in range(model.nbody)}
        links, joints = {names[0]: self._link(0, names[0], anchors[0])}, []
        for body in range(1, model.nbody):
            first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
            moving = [joint for joint in range(first, first + count) if self._does_move(joint)]
            parent, above = names[int(model.body_parentid[body])], int(model.body_parentid[body])
            pose = _pose(model.body_pos[body], model.body_quat[body])
            origin = make_transform(np.eye(3), -anchors[above]) @ pose
            anchors[body] = np.zeros(3)
            for number, joint in enumerate(moving):
                last = number == len(moving) - 1
                child = names[body] if last else f"{names[body]}_before_{number}"
                step = model.jnt_pos[joint] - anchors[body]
                anchors[body] = model.jnt_pos[joint].copy()
                joints.append(self._joint(joint, parent, child, origin @ make_transform(np.eye(3), step)))
                if not last:
                    links[child] = _helper(child)
                parent, origin = child, np.eye(4)
            if not moving:
                joints.append(JointModel(f"fixed_{body}", "fixed", parent, names[body], origin))
            links[names[body]] = self._link(body, names[body], anchors[body])
        return links, joints

    def remarks(self) -> list[str]:
        """What of the file is shown otherwise, fixed or left out, in lines; to be asked when all has been read."""
        model, lines = self.model, list[str]()
        if self.averaged:
            names = ", ".join(f"'{name}'" for name in sorted(self.averaged)[:5])
            lines.append(f"shown in the mean color of their textures, which no mesh places: materials {names}")
        still = [joint for joint in range(model.njnt) if not self._does_move(joint) and model.jnt_type[joint] != FREE]
        if still:
            names = ", ".join(f"'{model.joint(joint).name or joint}'" for joint in still[:5])
            lines.append(f"fixed: {len(still)} joints ({names}), which have no limits or turn as balls do")
        counts = {
            "equality constraints": model.neq - len(self.pairs),
            "tendons": model.ntendon,
            "soft bodies": model.nflex,
            "skins": model.nskin,
            **{name: int((model.geom_type == kind).sum()) for kind, name in UNSEEN.items()},
        }
        if left := [f"{count} {name}" for name, count in counts.items() if count]:
            lines.append(f"has what is not read: {', '.join(left)}")
        return lines

    def _does_move(self, joint: int) -> bool:
        model = self.model
        ends = np.abs(model.jnt_range[joint])  # a door's or drawer's, closed at one, may not hold in the simulation
        limited = bool(np.ptp(model.jnt_range[joint]) > THIN) and (model.jnt_limited[joint] or ends.min() == 0)
        return mjtJoint(model.jnt_type[joint]) in (mjtJoint.mjJNT_SLIDE, mjtJoint.mjJNT_HINGE) and limited

    def _joint(self, joint: int, parent: str, child: str, origin: Matrix) -> JointModel:
        model = self.model
        low, high = (model.jnt_range[joint] - model.qpos0[model.jnt_qposadr[joint]]).tolist()
        kind: Literal["prismatic", "revolute"]
        kind = "prismatic" if model.jnt_type[joint] == mjtJoint.mjJNT_SLIDE else "revolute"
        name, axis = model.joint(joint).name or f"joint_{joint}", model.jnt_axis[joint].copy()
        follows = self.pairs.get(joint)
        return close_at_lower(JointModel(name, kind, parent, child, origin, axis, low, high, follows=follows))

    def _pairs(self) -> dict[int, str]:
        """The joints that an equality makes stand like another of the same body and type, and the names of those."""
        model, pairs = self.model, dict[int, str]()
        for number in np.flatnonzero((model.eq_type == mjtEq.mjEQ_JOINT) & model.eq_active0.astype(bool)):
            one, other, data = model.eq_obj1id[number], model.eq_obj2id[number], model.eq_data[number]
            sign = float(np.sign(data[1]))
            if other < 0 or not np.allclose(data[:5], (0, sign, 0, 0, 0), atol=1e-3):
                continue
            parents = model.body_parentid[model.jnt_bodyid[[one, other]]]
            alike = model.jnt_type[one] == model.jnt_type[other] and parents[0] == parents[1]
            low, high = model.jnt_range[other]
            alike = alike and np.allclose(model.jnt_range[one], sorted([sign * low, sign * high]), atol=1e-3)
            alike = alike and (sign > 0 or abs(low) != abs(high))  # else both may open to one side
            if alike and self._does_move(one) and self._does_move(other):
                pairs[int(one)] = model.joint(other).name or f"joint_{other}"
        return pairs

    def _link(self, body: int, name: str, anchor: Matrix) -> Link:
        model, first = self.model, int(self.model.body_geomadr[body])
        geoms = list(range(first, first + int(model.body_geomnum[body])))
        frames = {
            geom: make_transform(np.eye(3), -anchor) @ _pose(model.geom_pos[geom], model.geom_quat[geom])
            for geom in geoms
        }
        seen = [geom for geom in geoms if self.shown[geom]]
        if self.has_visuals:
            seen = [geom for geom in seen if not self.collides[geom]] or seen
        visuals = [visual.transform(frames[geom]) for geom in seen for visual in self._visuals(geom)]
        touched = [geom for geom in geoms if self.collides[geom]]
        solid = [transform_mesh(mesh, frames[geom]) for geom in touched for mesh in self._meshes(geom)]
        solid = solid or [visual.mesh for visual in visuals]
        pieces = [piece for mesh in solid for piece in convex_pieces(mesh)]
        mass = min(float(model.body_mass[body]), self.masses.get(body, 0.0))
        if mass > MINIMUM_MASS:  # what nothing weighs has that of `compiled`
            turn = _pose(model.body_ipos[body], model.body_iquat[body])[:3, :3]
            inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T * (mass / model.body_mass[body])
            return Link(name, visuals, pieces, mass, model.body_ipos[body] - anchor, inertia, weighed=True)
        mass = board_mass(pieces, visuals)
        return Link(name, visuals, pieces, mass, box_around(pieces).mean(axis=0), box_inertia(pieces, mass))

    def _meshes(self, geom: int) -> Iterator[Trimesh]:
        """The shape of a geom in its own frame; nothing for planes, height fields and the like."""
        model, size = self.model, self.model.geom_size[geom]
        kind = model.geom_type[geom]
        if kind == mjtGeom.mjGEOM_BOX:
            yield trimesh.creation.box(2 * size)
        elif kind == mjtGeom.mjGEOM_SPHERE:
            yield trimesh.creation.icosphere(2, size[0])
        elif kind == mjtGeom.mjGEOM_ELLIPSOID:
            yield transform_mesh(trimesh.creation.icosphere(2), np.diag([*size, 1.0]))
        elif kind == mjtGeom.mjGEOM_CYLINDER:
            yield trimesh.creation.cylinder(size[0], 2 * size[1])
        elif kind == mjtGeom.mjGEOM_CAPSULE:
            mesh = trimesh.creation.capsule(2 * size[1], size[0])
            mesh.apply_translation([0, 0, -mesh.bounds.mean(axis=0)[2]])
            yield mesh
        elif kind == mjtGeom.mjGEOM_MESH:
            number = int(model.geom_dataid[geom])
            start, count = int(model.mesh_vertadr[number]), int(model.mesh_vertnum[number])
            face, faces = int(model.mesh_faceadr[number]), int(model.mesh_facenum[number])
            corners = model.mesh_vert[start : start + count][model.mesh_face[face : face + faces]]
            yield Trimesh(corners.reshape(-1, 3), np.arange(3 * faces).reshape(-1, 3), process=False)

    def _visuals(self, geom: int) -> Iterator[Visual]:
        model, material = self.model, int(self.model.geom_matid[geom])
        color = self.rgba[geom].clip(0, 1).astype(float)
        image = None if material < 0 else self._image(self._texture(material))
        for mesh in self._meshes(geom):
            uv = self._uv(geom) if image is not None and image.width > 1 else None
            if uv is not None:
                textured = trimesh.visual.material.PBRMaterial(
                    baseColorTexture=image, baseColorFactor=color, metallicFactor=0.0, roughnessFactor=0.8
                )
                mesh.visual = trimesh.visual.TextureVisuals(uv=uv, material=textured)
                yield Visual(mesh)
                continue
            mesh.merge_vertices()
            plain = color.copy()
            if image is not None:
                texels = np.asarray(image, dtype=float).reshape(-1, 3)
                plain[:3] *= (texels.mean(axis=0) / 255) ** 2.2
                if np.ptp(texels, axis=0).max() > PLAIN:
                    self.averaged.add(model.mat(material).name)
            red, green, blue, alpha = plain.round(4).tolist()
            rgba: RGBA = (red, green, blue, alpha)
            yield Visual(mesh, rgba, flat=model.geom_type[geom] == mjtGeom.mjGEOM_BOX)

    def _uv(self, geom: int) -> Matrix | None:
        """Where the corners of a mesh's faces lie in its texture, v upwards; None if it does not say."""
        model, mesh = self.model, int(self.model.geom_dataid[geom])
        if model.geom_type[geom] != mjtGeom.mjGEOM_MESH or model.mesh_texcoordadr[mesh] < 0:
            return None
        if model.tex_type[self._texture(int(model.geom_matid[geom]))] != mjtTexture.mjTEXTURE_2D:
            return None
        face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        corners = int(model.mesh_texcoordadr[mesh]) + model.mesh_facetexcoord[face : face + faces].ravel()
        return np.asarray(model.mesh_texcoord[corners] * [1, -1] + [0, 1], dtype=float)

    def _texture(self, material: int) -> int:
        """Number of the texture that colors a material; -1: none does."""
        roles = self.model.mat_texid[material]
        return int(max(roles[mjtTextureRole.mjTEXROLE_RGB], roles[mjtTextureRole.mjTEXROLE_RGBA]))

    def _image(self, texture: int) -> Image.Image | None:
        if texture < 0:
            return None
        model, channels = self.model, int(self.model.tex_nchannel[texture])
        height, width, start = (int(of[texture]) for of in (model.tex_height, model.tex_width, model.tex_adr))
        data = model.tex_data[start : start + height * width * channels].reshape(height, width, channels)
        return Image.fromarray(np.ascontiguousarray(np.broadcast_to(data[..., :3], (height, width, 3))))


def _read_stated_mass(body: Any) -> float | None:
    """The most that a body weighs, if it or its geoms say so: MuJoCo takes geoms that do not, looks too, for water."""
    water = mujoco.MjSpec().default.geom.density
    if body.explicitinertial or any(geom.density != water for geom in body.geoms):
        return float("inf")
    masses = [geom.mass for geom in body.geoms if not np.isnan(geom.mass)]
    return sum(masses) if masses else None


def _helper(name: str) -> Link:
    """A link without shape, between two joints of one body."""
    mass = board_mass([], [])
    return Link(name, [], [], mass, np.zeros(3), box_inertia([], mass))


def _pose(position: Matrix, quaternion: Matrix) -> Matrix:
    """4x4 of a position and a quaternion w, x, y, z."""
    rotation = Rotation.from_quat(quaternion, scalar_first=True)
    return make_transform(rotation.as_matrix(), np.array(position, dtype=float))


IMPORTER = Importer(read_mjcf, suffix=".xml")
