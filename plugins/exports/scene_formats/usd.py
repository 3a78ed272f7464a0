"""A folder for USD (Isaac Sim, Omniverse): scene.usdc with UsdPhysics bodies and joints, textures beside it."""

from pathlib import Path
from typing import Any

import numpy as np

from roomkin.stages.articulated.asset_folder import atomic_folder
from roomkin.stages.articulated.mesh_writer import ColoredMesh, surfaces
from roomkin.stages.articulated.model import JointModel, Link, Matrix
from roomkin.stages.articulated.urdf_writer import DAMPING, SURFACE_FRICTION
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.system import sync
from roomkin.stages.generation.scene_file import CAMERA, Body, ExportedScene, surface_of
from roomkin.stages.geometry.frames import OPENGL, make_transform, quaternion_from_matrix, yaw_matrix

try:
    from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, Vt
except ImportError:
    what = "usd-core is not installed."
    raise InputError("--format usd", what, "pip install usd-core", code="E-USD-MISSING") from None

ROOT, LOOKS = "/World", "/World/Looks"


def write(room: ExportedScene, out: Path) -> None:
    """Write the folder `out`: metres, kilograms, z up. Joints are at their lower limits."""
    with atomic_folder(out) as folder:
        stage = Usd.Stage.CreateNew(str(folder / "scene.usdc"))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
        stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
        physics = UsdPhysics.Scene.Define(stage, f"{ROOT}/Physics")
        physics.CreateGravityDirectionAttr(Gf.Vec3f(0, 0, -1))
        physics.CreateGravityMagnitudeAttr(9.81)
        writer = _Writer(stage, folder)
        writer.surroundings(room)
        for body in room.bodies:
            writer.body(body)
        stage.GetRootLayer().Save()
        sync(folder)


class _Writer:
    """Writes prims into a stage."""

    def __init__(self, stage: Any, folder: Path) -> None:
        self.stage, self.folder = stage, folder
        self.materials: dict[Any, Any] = {}
        self.textures: dict[Any, str] = {}
        self.rough = UsdShade.Material.Define(stage, f"{LOOKS}/rough")
        friction = UsdPhysics.MaterialAPI.Apply(self.rough.GetPrim())
        friction.CreateStaticFrictionAttr(SURFACE_FRICTION)
        friction.CreateDynamicFrictionAttr(SURFACE_FRICTION)

    def surroundings(self, room: ExportedScene) -> None:
        """Floor, walls, light and camera."""
        for block in room.blocks:
            path = f"{ROOT}/{_name(block.name)}"
            _place(UsdGeom.Xform.Define(self.stage, path), make_transform(yaw_matrix(block.yaw), block.center))
            surface = surface_of(block)
            self._write_visual(f"{path}/visual", surface)
            self._write_collision(f"{path}/collision", surface.vertices, surface.faces)
        light = UsdLux.DistantLight.Define(self.stage, f"{ROOT}/key_light")
        light.CreateIntensityAttr(2000.0)
        light.CreateAngleAttr(1.0)
        _place(light, make_transform(_turn(np.array([0.0, 0.0, -1.0]), room.light), [0, 0, 5.0]))
        UsdLux.DomeLight.Define(self.stage, f"{ROOT}/fill_light").CreateIntensityAttr(400.0)
        scene, k = room.scene, np.array(room.scene.intrinsics)
        camera = UsdGeom.Camera.Define(self.stage, f"{ROOT}/{CAMERA}")
        aperture = camera.GetHorizontalApertureAttr().Get()  # millimetres, USD's usual film
        pixel = aperture / scene.width
        camera.CreateFocalLengthAttr(float(k[0, 0] * pixel))
        camera.CreateHorizontalApertureAttr(aperture)
        camera.CreateVerticalApertureAttr(float(scene.height * pixel * k[0, 0] / k[1, 1]))
        camera.CreateHorizontalApertureOffsetAttr(float(((scene.width - 1) / 2 - k[0, 2]) * pixel))
        camera.CreateVerticalApertureOffsetAttr(float((k[1, 2] - (scene.height - 1) / 2) * pixel * k[0, 0] / k[1, 1]))
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.05, 100.0))
        _place(camera, room.world_from_camera @ OPENGL)

    def body(self, body: Body) -> None:
        """An object: its links side by side, each in its place, and the joints between them."""
        path = f"{ROOT}/{_name(body.id)}"
        top = UsdGeom.Xform.Define(self.stage, path)
        _place(top, body.pose)
        top.GetPrim().SetDisplayName(body.label)
        top.GetPrim().SetMetadata("comment", f"{body.asset.category}: {body.asset.id}")
        alone = not body.model.joints
        for name, link in body.model.links.items():
            self._link(f"{path}/{_name(name)}", link, body.frames[name], moves=not (alone and body.fixed))
        if not alone:
            UsdPhysics.ArticulationRootAPI.Apply(top.GetPrim())
        if body.fixed and not alone:
            held = UsdPhysics.FixedJoint.Define(self.stage, f"{path}/held")
            held.CreateBody1Rel().SetTargets([Sdf.Path(f"{path}/{_name(body.model.root)}")])
            _frame(held, 0, body.pose)
            _frame(held, 1, np.eye(4))
        for joint in body.model.joints:
            self._joint(path, joint)

    def _link(self, path: str, link: Link, pose: Matrix, moves: bool) -> None:
        prim = UsdGeom.Xform.Define(self.stage, path)
        _place(prim, pose)
        if moves:
            UsdPhysics.RigidBodyAPI.Apply(prim.GetPrim())
            mass = UsdPhysics.MassAPI.Apply(prim.GetPrim())
            values, axes = np.linalg.eigh(link.inertia)
            axes[:, 2] *= np.sign(np.linalg.det(axes))
            mass.CreateMassAttr(float(link.mass))
            mass.CreateCenterOfMassAttr(Gf.Vec3f(*link.center.tolist()))
            mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*values.tolist()))
            mass.CreatePrincipalAxesAttr(_quaternion(axes))
        for number, surface in enumerate(surfaces(link)):
            self._write_visual(f"{path}/visual_{number}", surface)
        for number, piece in enumerate(link.collisions):
            self._write_collision(f"{path}/collision_{number}", piece.vertices, piece.faces)

    def _joint(self, path: str, joint: JointModel) -> None:
        kind = {"fixed": UsdPhysics.FixedJoint, "revolute": UsdPhysics.RevoluteJoint}
        prim = kind.get(joint.type, UsdPhysics.PrismaticJoint).Define(self.stage, f"{path}/{_name(joint.name)}_joint")
        prim.CreateBody0Rel().SetTargets([Sdf.Path(f"{path}/{_name(joint.parent)}")])
        prim.CreateBody1Rel().SetTargets([Sdf.Path(f"{path}/{_name(joint.child)}")])
        along = make_transform(_turn(np.eye(3)[0], joint.axis), np.zeros(3))  # the joint's x axis is that of the motion
        _frame(prim, 0, joint.origin @ along)
        _frame(prim, 1, along)
        if joint.type == "fixed":
            return
        prim.CreateAxisAttr("X")
        hinge = joint.type == "revolute"
        unit = 180 / np.pi if hinge else 1.0
        prim.CreateLowerLimitAttr(float(joint.lower * unit))
        prim.CreateUpperLimitAttr(float(joint.upper * unit))
        drive = UsdPhysics.DriveAPI.Apply(prim.GetPrim(), "angular" if hinge else "linear")
        drive.CreateDampingAttr(DAMPING / unit if hinge else DAMPING)
        drive.CreateStiffnessAttr(0.0)

    def _mesh(self, path: str, vertices: Any, faces: Any) -> Any:
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(vertices, dtype=np.float32)))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray([3] * len(faces)))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(faces, dtype=np.int32).ravel()))
        mesh.CreateSubdivisionSchemeAttr("none")
        return mesh

    def _write_visual(self, path: str, surface: ColoredMesh) -> None:
        mesh = self._mesh(path, surface.vertices, surface.faces)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(surface.normals.astype(np.float32)))
        mesh.SetNormalsInterpolation("vertex")
        mesh.CreateDisplayColorAttr(Vt.Vec3fArray([Gf.Vec3f(*surface.color[:3])]))
        if surface.uv is not None:
            at = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex")
            at.Set(Vt.Vec2fArray.FromNumpy(surface.uv.astype(np.float32)))
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(self._material(surface))

    def _write_collision(self, path: str, vertices: Any, faces: Any) -> None:
        """A convex piece, that renderers leave out."""
        mesh = self._mesh(path, vertices, faces)
        mesh.CreatePurposeAttr(UsdGeom.Tokens.guide)
        UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
        UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr("convexHull")
        binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
        binding.Bind(self.rough, UsdShade.Tokens.weakerThanDescendants, "physics")

    def _material(self, surface: ColoredMesh) -> Any:
        key = (surface.color, None if surface.image is None else surface.image.tobytes())
        if key in self.materials:
            return self.materials[key]
        path = f"{LOOKS}/look_{len(self.materials)}"
        material = self.materials[key] = UsdShade.Material.Define(self.stage, path)
        shader = UsdShade.Shader.Define(self.stage, f"{path}/surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.8)
        diffuse = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        diffuse.Set(Gf.Vec3f(*surface.color[:3]))
        if surface.image is not None:
            diffuse.ConnectToSource(self._texture(path, surface).ConnectableAPI(), "rgb")
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        return material

    def _texture(self, path: str, surface: ColoredMesh) -> Any:
        assert surface.image is not None
        image = surface.image.convert("RGB")
        file = self.textures.setdefault((image.size, image.tobytes()), f"textures/texture_{len(self.textures)}.png")
        (self.folder / "textures").mkdir(exist_ok=True)
        image.save(self.folder / file)
        reader = UsdShade.Shader.Define(self.stage, f"{path}/uv")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        texture = UsdShade.Shader.Define(self.stage, f"{path}/texture")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./{file}")
        texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*surface.color))
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
        texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
        return texture


def _name(text: str) -> str:
    return str(Tf.MakeValidIdentifier(text))


def _quaternion(rotation: Matrix) -> Any:
    w, x, y, z = quaternion_from_matrix(rotation).tolist()
    return Gf.Quatf(w, x, y, z)


def _place(prim: Any, pose: Matrix) -> None:
    w, x, y, z = quaternion_from_matrix(pose[:3, :3]).tolist()
    prim.AddTranslateOp().Set(Gf.Vec3d(*pose[:3, 3].tolist()))
    prim.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(w, x, y, z))


def _frame(joint: Any, side: int, pose: Matrix) -> None:
    getattr(joint, f"CreateLocalPos{side}Attr")(Gf.Vec3f(*pose[:3, 3].tolist()))
    getattr(joint, f"CreateLocalRot{side}Attr")(_quaternion(pose[:3, :3]))


def _turn(start: Matrix, end: Matrix) -> Matrix:
    """A rotation (3, 3) that takes one direction to another."""
    a, b = (np.asarray(v, dtype=float) / np.linalg.norm(v) for v in (start, end))
    turn = Gf.Rotation(Gf.Vec3d(*a.tolist()), Gf.Vec3d(*b.tolist()))
    return np.array(Gf.Matrix3d(turn)).T  # USD multiplies rows
