"""The stock Panda for films, with a fifth of its triangles: software rendering is bound by vertices."""

import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
import open3d
import trimesh

from roomkin.stages.simulation.robot import PANDA
from roomkin.stages.simulation.shaders import cache_folder

SHARE = 0.2  # of the triangles that are kept; chosen: a film looks the same
CREASE = 0.6  # radians between two faces from which on their edge is sharp; chosen
VERSION = 1  # of what is kept on a machine between runs; to be raised with any change here


@cache
def film_urdf() -> Path:
    """Its URDF; it is made once on a machine."""
    folder = cache_folder() / f"panda-film-{VERSION}"
    if not folder.is_dir():
        made = Path(tempfile.mkdtemp(dir=cache_folder()))
        tree = ElementTree.parse(PANDA)
        for mesh in tree.iter("mesh"):
            path = PANDA.parent / str(mesh.get("filename"))
            mesh.set("filename", str(path))
            if path.suffix == ".glb":
                thin_scene(path).export(made / path.name)
                mesh.set("filename", str(folder / path.name))
        (made / "panda.srdf").write_text(PANDA.with_suffix(".srdf").read_text(encoding="utf-8"), encoding="utf-8")
        tree.write(made / "panda.urdf")
        with suppress(OSError):  # another job was faster
            made.rename(folder)
        shutil.rmtree(made, ignore_errors=True)
    return folder / "panda.urdf"


def thin_scene(path: Path) -> trimesh.Scene:
    """The meshes of a file with a share of their triangles, in their materials."""
    scene = trimesh.load_scene(path)
    for name, mesh in scene.geometry.items():
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        corners = open3d.utility.Vector3dVector(np.asarray(mesh.vertices))
        solid = open3d.geometry.TriangleMesh(corners, open3d.utility.Vector3iVector(np.asarray(mesh.faces)))
        solid = solid.simplify_quadric_decimation(max(12, round(SHARE * len(mesh.faces))))
        thin = trimesh.Trimesh(np.asarray(solid.vertices), np.asarray(solid.triangles), process=False)
        thin = trimesh.graph.smooth_shade(thin, angle=CREASE)
        thin.visual = trimesh.visual.TextureVisuals(material=mesh.visual.material)
        scene.geometry[name] = thin
    return scene
