"""One MJCF file as MuJoCo reads it: what it includes put in its place, files named by whole paths, inside a folder."""

import importlib.util
import io
import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from PIL import Image

from stages.articulated.inside import OutsideError, find_inside, missing
from stages.articulated.urdf_reader import LOST
from stages.articulated.urdf_tree import AROUND
from stages.assets.mjcf_mending import compile_mended
from stages.contracts.errors import InputError

DEEPEST = 20  # files that include each other
KEPT = {"asset", "compiler", "default", "worldbody"}  # all else is control, sensors and looks of a viewer
# Nothing is thrown away or merged, and the whole paths that we write count.
COMPILER = {"discardvisual": "false", "fusestatic": "false", "strippath": "false"}

READ = {".png", ".bin"}  # textures that MuJoCo reads
GREY = {"type": "2d", "builtin": "flat", "width": "1", "height": "1", "rgb1": ".7 .7 .7"}


def compiled(path: Path, folder: Path) -> tuple[Any, Any, list[str]]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of a file; lines say what was left out or assumed.

    Raises:
        InputError: MuJoCo is missing or refuses the file, it is a part of a model, or names files outside `folder`.
    """
    root = parsed(path)
    if root.tag != "mujoco":
        raise InputError(path, f"has <{root.tag[:40]}> at the top.", "a model in MJCF starts with <mujoco>")
    if importlib.util.find_spec("mujoco") is None:
        raise InputError(path, "is MJCF, which MuJoCo reads.", "pip install mujoco")
    pictures: dict[str, bytes] = {}
    lost: dict[str, InputError] = {}
    directories = {"mesh": "", "texture": "", "hfield": ""}
    own = root.findall("worldbody")
    _include(root, path, path, folder, 0)
    remarks = _without_surroundings(root, own)
    _rename_defaults(root)
    settings = COMPILER | ({"angle": "radian"} if _in_radians(root) else {})
    for compiler in root.iter("compiler"):
        told = compiler.attrib
        for kind, key in (("mesh", "meshdir"), ("hfield", "meshdir"), ("texture", "texturedir")):
            directories[kind] = told.get(key, told.get("assetdir", directories[kind]))
    for element in root.iter():
        for key in [key for key in element.attrib if key.startswith("file")]:
            name = Path(slashed(directories.get(element.tag, "")), slashed(element.attrib[key]))
            try:
                found = _inside(name, path, folder)
                element.set(key, str(found))
                if element.tag == "texture" and found.suffix.lower() not in READ:
                    pictures[f"{found}.png"] = _png(found, path)
                    element.set(key, f"{found}.png")
            except InputError as error:
                if element.tag == "mesh":
                    lost.setdefault(element.get("name", Path(slashed(element.attrib[key])).stem), error)
                    break
                if element.tag != "texture":
                    raise
                remarks.append(f"grey in place of a texture: {str(error).removeprefix(f'{path}: ')}")
                named = element.get("name", Path(slashed(element.attrib[key])).stem)
                element.attrib.clear()
                element.attrib.update({"name": named} | GREY)
                break
    remarks += _without_meshes(root, lost, path)
    for element in [element for element in root if element.tag not in KEPT]:
        root.remove(element)
    ET.SubElement(root, "compiler", settings)
    spec, model, mended = compile_mended(root, path, pictures)
    return spec, model, [*remarks, *mended]


def _without_meshes(root: ET.Element, lost: dict[str, InputError], path: Path) -> list[str]:
    """Leave out meshes whose files are missing, by name; lines say so. If they are more than few, that is an error."""
    if len(lost) > LOST * sum(mesh.get("file") is not None for mesh in root.iter("mesh")):
        raise next(iter(lost.values()))
    for parent in list(root.iter()):
        for child in list(parent):
            named = child.get("name") if child.tag == "mesh" else child.get("mesh")
            if named is None and child.tag == "mesh":
                named = Path(slashed(child.get("file", ""))).stem
            if named in lost:
                parent.remove(child)
    return [f"left out: mesh '{name}': {str(error).removeprefix(f'{path}: ')}" for name, error in lost.items()]


def _png(picture: Path, path: Path) -> bytes:
    """A picture as MuJoCo reads it."""
    buffer = io.BytesIO()
    try:
        with Image.open(picture) as image:
            image.convert("RGB").save(buffer, "PNG")
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise InputError(path, f"{picture.name} is no picture ({type(error).__name__}).") from None
    return buffer.getvalue()


def _without_surroundings(root: ET.Element, own: list[ET.Element]) -> list[str]:
    """Leave out the worlds that included files bring (a table, a room) if the file itself puts something into its own;
    a line says so."""

    def holds(world: ET.Element) -> bool:
        return world.find(".//body") is not None or any(geom.get("type") != "plane" for geom in world.iter("geom"))

    included = [world for world in root.findall("worldbody") if world not in own and holds(world)]
    if not included or not any(holds(world) for world in own):
        return []
    for world in included:
        root.remove(world)
    names = [f"'{body.get('name', '')}'" for world in included for body in world.findall("body")]
    return [f"left out, as included around it: {', '.join(names) or 'geoms of the world'}"]


def _rename_defaults(root: ET.Element) -> None:
    """Call the outermost class of defaults `main`, as MuJoCo now wants it; files used to call it as they liked."""
    names = {default.get("class") for default in root.findall("default")} - {None, "main"}
    for element in root.iter():
        for key in ("class", "childclass"):
            if element.get(key) in names:
                element.set(key, "main")


def _in_radians(root: ET.Element) -> bool:
    """Whether angles must be radians, as no hinge turns by so few degrees: parts of a simulation that says so elsewhere
    do not say it themselves."""
    if any("angle" in compiler.attrib for compiler in root.iter("compiler")):
        return False
    hinges = [
        joint for joint in root.iter("joint") if joint.get("type", "hinge") == "hinge" and "range" in joint.attrib
    ]
    texts = [joint.get("range", "") for joint in hinges] + [element.get("euler", "") for element in root.iter()]
    try:
        angles = [abs(float(word)) for text in texts for word in text.split()]
    except ValueError:  # MuJoCo says what is wrong with it
        return False
    return bool(hinges) and max(angles, default=0.0) <= 2 * math.pi


def parsed(path: Path) -> ET.Element:
    """The root of an MJCF file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
        if "<!DOCTYPE" in text:
            raise InputError(path, "declares a DOCTYPE, which MJCF does not need.", "remove it")
        return ET.fromstring(text.strip(AROUND))
    except (OSError, UnicodeDecodeError, ET.ParseError, ValueError) as error:
        raise InputError(path, f"is not XML: {error}.") from None


def root_tag(path: Path) -> str:
    """Name of the outermost element; empty if there is none."""
    try:
        return next((element.tag for _, element in ET.iterparse(path, ["start"])), "")
    except (OSError, ET.ParseError, ValueError):
        return ""


def _include(element: ET.Element, here: Path, path: Path, folder: Path, depth: int) -> None:
    """Put what is included in the place of every <include>."""
    if depth > DEEPEST:
        raise InputError(path, "its files include each other without end.")
    for index in range(len(element) - 1, -1, -1):
        child = element[index]
        if child.tag == "include":
            file = _inside(Path(slashed(child.get("file", ""))), here, folder, path)
            part = parsed(file)
            _include(part, file, path, folder, depth + 1)
            element[index : index + 1] = list(part)
        else:
            _include(child, here, path, folder, depth)


def slashed(name: str) -> str:
    """A file's name as other systems than Windows write it."""
    return name.replace("\\", "/")


def _inside(name: Path, here: Path, folder: Path, above: Path | None = None) -> Path:
    """A file by its name in MJCF: relative to the file `here` or to the model `above`, or with folders renamed."""
    try:
        plain = Path(*[part for part in name.parts if part not in ("..", "/")])
        for name_, base in ((name, here), (name, above or here), (plain, here)):
            if name_.is_absolute():
                continue
            direct = (base.parent / name_).resolve()
            if direct.is_file() and direct.is_relative_to(folder.resolve()):
                return direct
        found = find_inside(str(plain), here.parent, folder)
    except OutsideError:
        found = None
    if found is None:
        raise missing(above or here, "there is no file", str(name), here.parent, folder)
    return found
