"""SAPIEN's shaders without sky light: the first picture is 6 seconds faster, all others by a fifth.

If a shader names the sky, SAPIEN fills a table for it before the first picture, and every pixel looks it up.
No scene of ours has a sky, and a missing sky is black: the pictures are the same, pixel for pixel.
"""

import hashlib
import os
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import Literal

import sapien

Pack = Literal["default", "minimal"]
TABLE = re.compile(r"^layout\(.*\) uniform sampler2D samplerBRDFLUT;$", re.MULTILINE)
READ = re.compile(r"texture\(samplerBRDFLUT, [^;]*\)\.xy;")
SKY = re.compile(r"textureLod\(samplerEnvironment, [^;]*\)\.rgb;")
FORMATS: dict[Pack, tuple[str, str]] = {
    "default": ("r32g32b32a32sfloat", "r32g32b32a32sfloat"),
    "minimal": ("r8g8b8a8unorm", "r16g16b16a16sint"),
}


def cache_folder() -> Path:
    """Where generated files are kept between runs; a temporary folder if the home is not writable."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = home / "roomkin"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    return folder if writable else Path(tempfile.gettempdir()) / "roomkin"


def keep(folder: Path, files: dict[str, str]) -> Path:
    """Write generated files below `folder` unless they are there; two jobs may come here at once."""
    for name, text in files.items():
        file = folder / name
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.parent.mkdir(parents=True, exist_ok=True)
            own = file.with_name(f"{os.getpid()}-{file.name}")
            own.write_text(text, encoding="utf-8")
            own.replace(file)
    return folder


def use(pack: Pack) -> None:
    """The next cameras are made with a pack: `default` (color and positions as floats), or `minimal`, thrice as fast
    (color as bytes, positions and segmentation as 16 bit integers, millimetres)."""
    sapien.render.set_camera_shader_dir(make_skyless_pack(pack))
    color, position = FORMATS[pack]
    for name, texture in (("Color", color), ("ColorRaw", color), ("PositionSegmentation", position)):
        sapien.render.set_picture_format(name, texture)


@cache
def make_skyless_pack(pack: str) -> str:
    """Folder of the shader pack without the table and the sky; the pack's own name if it is not as we know it."""
    shipped = Path(sapien.__file__).parent / "vulkan_shader"
    files = {
        f"{part}/{path.name}": path.read_text(encoding="utf-8")
        for part in (pack, "common")
        for path in sorted((shipped / part).iterdir())
    }
    changed = {name: SKY.sub("vec3(0.0);", READ.sub("vec2(0.0);", TABLE.sub("", text))) for name, text in files.items()}
    if changed == files or any("samplerBRDFLUT" in text for text in changed.values()):
        return pack
    digest = hashlib.sha256("\0".join(changed.values()).encode()).hexdigest()[:16]
    return str(keep(cache_folder() / f"shaders-{digest}", changed) / pack)
