"""Command `scenes`: generated scenes in the format of another tool."""

from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from roomkin.plugins.pictures import glb
from roomkin.stages.contracts import GeneratedScene, read_json
from roomkin.stages.contracts.generated import Look
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.generation.scene_file import read_items, room_of


def run(
    *,
    scenes: tuple[Path, ...],
    library: Path,
    format: Literal["glb", "urdf", "mjcf", "usd"],
    out: Path,
    look: Path | None = None,
) -> None:
    """Write scenes for another tool, each with all that belongs to it into a folder rank_<n>.

    Args:
        scenes: scene_<rank>.json files.
        library: library.json.
        format: glb: scene.glb, to look at; urdf: scene.urdf and a URDF per object; mjcf: scene.xml for MuJoCo; usd:
            scene.usdc for Isaac Sim and others.
        out: folder; gets rank_<n>/ of each scene.
        look: look.json of the picture, for the colors of floor and walls and the light; default: grey.
    """
    folders = AssetFolders(library)
    writer = glb if format == "glb" else import_module(f"roomkin.plugins.exports.scene_formats.{format}")
    looks = read_json(Look, look) if look else None
    with TemporaryDirectory(prefix="acdc-sized-") as cache:
        for path in scenes:
            generated = read_json(GeneratedScene, path)
            items = read_items(generated, folders, Path(cache), path)
            folder = out / f"rank_{generated.rank}"
            writer.write(room_of(generated, items, looks), folder / "scene.glb" if format == "glb" else folder)
