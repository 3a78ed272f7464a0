"""A scene for MuJoCo: the bodies of its world are things, z is up; a camera called `camera` or `input_camera`."""

from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import trimesh

from roomkin.plugins.scorecard.readers.glb import CAMERAS
from roomkin.plugins.scorecard.readers.solid import describe_solid, make_scene
from roomkin.plugins.scorecard.truth import About, RoomScene
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_text
from roomkin.stages.geometry.frames import OPENGL, make_transform

FOLDERS = ("meshdir", "texturedir", "assetdir")


def read(path: Path, about: About) -> RoomScene:
    """The bodies below the world, each with all that hangs on it, as it stands at first.

    Raises:
        InputError: it names a file outside its folder or a plugin, has no camera, or is broken.
    """
    import mujoco

    check_confined(path)
    try:
        world = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise InputError(path.name, f"MuJoCo does not read it: {error}", code="E-FORMAT") from None
    data = mujoco.MjData(world)
    mujoco.mj_forward(world, data)
    named = [mujoco.mj_name2id(world, mujoco.mjtObj.mjOBJ_CAMERA, name) for name in CAMERAS]
    camera = next((number for number in named if number >= 0), -1)
    if camera < 0:
        raise InputError(path.name, "has no camera called 'camera'.", "add that of the picture", code="E-FORMAT")
    view = make_transform(data.cam_xmat[camera].reshape(3, 3), data.cam_xpos[camera])
    things, solids = list[dict[str, Any]](), dict[int, trimesh.Trimesh]()
    for body in range(1, world.nbody):
        if world.body_parentid[body]:
            continue
        geoms = [geom for geom in range(world.ngeom) if world.body_rootid[world.geom_bodyid[geom]] == body]
        seen = [geom for geom in geoms if not (world.geom_contype[geom] or world.geom_conaffinity[geom])] or geoms
        meshes = [mesh for geom in seen if (mesh := _read_geom(world, data, geom)) is not None]
        if meshes:
            name = (mujoco.mj_id2name(world, mujoco.mjtObj.mjOBJ_BODY, body) or "thing").partition("/")[0]
            thing, solids[len(things)] = describe_solid(name, meshes, data.xmat[body].reshape(3, 3))
            things.append(thing)
    return make_scene(things, view @ OPENGL, about, solids)


def check_confined(path: Path) -> None:
    """Refuse a file that makes MuJoCo open what is outside its folder, or load code.

    Raises:
        InputError: it names such a file, also by a link; a plugin; or another XML, which might.
    """
    text = read_text(path)
    if "<!DOCTYPE" in text:
        raise InputError(path.name, "declares a DOCTYPE, which MJCF does not need.", "remove it", code="E-XML-DOCTYPE")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InputError(path.name, f"is not XML: {error}.", code="E-XML-BROKEN") from None
    folder = path.parent.resolve()
    places = {"", *(element.get(key, "") for element in root.iter("compiler") for key in FOLDERS)}
    for element in root.iter():
        if element.tag in ("include", "plugin", "extension", "model"):
            what = f"has <{element.tag}>, which is not read."
            raise InputError(path.name, what, "one file without it", code="E-FORMAT")
        named = [value.replace("\\", "/") for key, value in element.attrib.items() if key.startswith("file")]
        for place, name in product(places, named):
            if not (folder / place.replace("\\", "/") / name).resolve().is_relative_to(folder):
                what = f"names '{name}', which lies outside its folder."
                raise InputError(path.name, what, "copy it there", code="E-FILE-OUTSIDE")


def _read_geom(world: Any, data: Any, geom: int) -> trimesh.Trimesh | None:
    """The surface of a geom in the world; None: it is a plane or a height field."""
    import mujoco

    kinds, size = mujoco.mjtGeom, world.geom_size[geom]
    kind = world.geom_type[geom]
    if kind == kinds.mjGEOM_MESH:
        mesh = world.geom_dataid[geom]
        start, count = world.mesh_vertadr[mesh], world.mesh_vertnum[mesh]
        first, faces = world.mesh_faceadr[mesh], world.mesh_facenum[mesh]
        points, corners = world.mesh_vert[start : start + count], world.mesh_face[first : first + faces]
        solid = trimesh.Trimesh(points, corners, process=False)
    elif kind == kinds.mjGEOM_BOX:
        solid = trimesh.creation.box(2 * size)
    elif kind == kinds.mjGEOM_SPHERE:
        solid = trimesh.creation.icosphere(radius=size[0])
    elif kind == kinds.mjGEOM_ELLIPSOID:
        solid = trimesh.creation.icosphere(radius=1.0).apply_scale(size)
    elif kind == kinds.mjGEOM_CYLINDER:
        solid = trimesh.creation.cylinder(size[0], 2 * size[1])
    elif kind == kinds.mjGEOM_CAPSULE:
        solid = trimesh.creation.capsule(2 * size[1], size[0])
    else:
        return None
    return solid.apply_transform(make_transform(data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]))
