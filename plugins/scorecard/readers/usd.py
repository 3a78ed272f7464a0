"""A USD stage whose prims are things: those below its root. Its up axis and unit are its own; the camera is a prim
called `camera` or `input_camera`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from roomkin.plugins.scorecard.readers.glb import CAMERAS, ROOM
from roomkin.plugins.scorecard.readers.solid import describe_solid, make_scene
from roomkin.plugins.scorecard.truth import About, RoomScene
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import OPENGL, Y_UP, invert_transform

try:
    from pxr import Sdf, Usd, UsdGeom
except ImportError:
    raise InputError("USD", "usd-core is not installed.", "pip install usd-core", code="E-USD-MISSING") from None

SHOWN = {UsdGeom.Tokens.default_, UsdGeom.Tokens.render}


def read(path: Path, about: About) -> RoomScene:
    """The things of a stage: prims below its root, or below the one prim that holds all.

    A prim's `category` or `label` in its custom data is the thing's name, or its display name, or its own.

    Raises:
        InputError: it names another layer, has no thing or no camera, or is broken; usd-core is not installed.
    """
    layer = Sdf.Layer.FindOrOpen(str(path))
    if layer is None:
        raise InputError(path.name, "is no USD.", code="E-FORMAT")
    check_alone(path, layer)
    stage = Usd.Stage.Open(layer, sessionLayer=None, load=Usd.Stage.LoadNone)
    unit = np.diag([*[UsdGeom.GetStageMetersPerUnit(stage)] * 3, 1.0])
    turn = invert_transform(Y_UP) if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y else np.eye(4)
    cache = UsdGeom.XformCache()
    things, solids = list[dict[str, Any]](), dict[int, trimesh.Trimesh]()
    camera = None
    for prim in _list_things(stage.GetDefaultPrim() or stage.GetPseudoRoot()):
        pose = turn @ _unscale(unit @ _matrix(cache.GetLocalToWorldTransform(prim)))
        if prim.GetName() in CAMERAS:
            camera = pose
            continue
        meshes = [
            mesh.apply_transform(turn @ unit @ _matrix(cache.GetLocalToWorldTransform(below)))
            for below in Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
            if (mesh := _read_shape(below)) is not None
        ]
        if not meshes or ROOM.fullmatch(prim.GetName()):
            continue
        custom = prim.GetCustomData()
        name = custom.get("category") or custom.get("label") or prim.GetDisplayName() or prim.GetName()
        thing, solids[len(things)] = describe_solid(str(name), meshes, pose[:3, :3])
        things.append(thing)
    if not things:
        raise InputError(path.name, "has no prim that is a thing.", "a prim below the root for each", code="E-FORMAT")
    if camera is None:
        raise InputError(path.name, "has no camera called 'camera'.", "add that of the picture", code="E-FORMAT")
    return make_scene(things, camera @ OPENGL, about, solids)


def check_alone(path: Path, layer: Sdf.Layer) -> None:
    """Refuse a layer that makes USD open another file: what is read comes from a stranger.

    Raises:
        InputError: it has sublayers, references or payloads in other files, or value clips.
    """
    clips = []
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda at: clips.append(at) if _has_clips(layer, at) else None)
    if layer.GetCompositionAssetDependencies() or clips:
        what = "names other layers, which are not read."
        raise InputError(path.name, what, f"one file: usdcat --flatten -o {path.name}", code="E-FORMAT")


def _has_clips(layer: Sdf.Layer, at: Sdf.Path) -> bool:
    spec = layer.GetPrimAtPath(at) if at.IsPrimPath() else None
    return spec is not None and "clips" in spec.ListInfoKeys()


def _matrix(value: Any) -> Any:
    """USD's row vectors as our columns."""
    return np.array(value).T


def _unscale(pose: Any) -> Any:
    """A pose without scale, which some programs put over everything."""
    whole = np.array(pose)
    whole[:3, :3] /= np.maximum(np.linalg.norm(whole[:3, :3], axis=0), 1e-9)
    return whole


def _list_things(prim: Usd.Prim) -> list[Usd.Prim]:
    """The prims below one; below the one that alone holds all."""
    below = prim.GetFilteredChildren(Usd.TraverseInstanceProxies())
    alone = len(below) == 1 and not below[0].IsA(UsdGeom.Gprim)
    return _list_things(below[0]) if alone and below[0].GetChildren() else list(below)


def _read_shape(prim: Usd.Prim) -> trimesh.Trimesh | None:
    """The surface of a prim in its own frame; None: it has none that is shown."""
    if not prim.IsA(UsdGeom.Gprim) or UsdGeom.Imageable(prim).ComputePurpose() not in SHOWN:
        return None
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        corners, counts = mesh.GetFaceVertexIndicesAttr().Get() or [], mesh.GetFaceVertexCountsAttr().Get() or []
        faces = np.array(list(_fan(corners, counts)), dtype=int).reshape(-1, 3)
        return trimesh.Trimesh(np.array(mesh.GetPointsAttr().Get()), faces, process=False) if len(faces) else None
    if prim.IsA(UsdGeom.Cube):
        return trimesh.creation.box([UsdGeom.Cube(prim).GetSizeAttr().Get()] * 3)
    if prim.IsA(UsdGeom.Sphere):
        return trimesh.creation.icosphere(radius=UsdGeom.Sphere(prim).GetRadiusAttr().Get())
    if prim.IsA(UsdGeom.Cylinder):
        shape = UsdGeom.Cylinder(prim)
        solid = trimesh.creation.cylinder(shape.GetRadiusAttr().Get(), shape.GetHeightAttr().Get())
        axis = {"X": (0, 1, 0), "Y": (1, 0, 0)}.get(str(shape.GetAxisAttr().Get()))
        return solid.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, axis)) if axis else solid
    return None


def _fan(corners: Any, counts: Any) -> Iterator[tuple[int, int, int]]:
    start = 0
    for count in counts:
        for k in range(1, count - 1):
            yield corners[start], corners[start + k], corners[start + k + 1]
        start += count
