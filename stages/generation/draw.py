"""Verb `draw`: generated scenes as pictures from the input camera, as GLB, and side by side with the input."""

from pathlib import Path

import numpy as np
from PIL import Image

from stages.articulated.asset_folder import read_asset
from stages.cli import progress
from stages.contracts import GeneratedScene, InputError, Library, atomic, read_json
from stages.contracts.objects import Mounting
from stages.generation.export import write_glb
from stages.generation.pictures import preview, read_picture, side_by_side
from stages.generation.placed import Placed
from stages.generation.settling import load_items
from stages.geometry.boxes import UprightBox
from stages.procedural.resize import resized
from stages.simulation.backdrop import add_backdrop
from stages.simulation.rendering import make_scene

LIGHT = (0.55, -0.5, -1.0)  # over the photographer's shoulder: x of the floor frame is the viewing direction
STANDING = Mounting(type=2)  # for scenes that do not say


def run(*, scenes: tuple[Path, ...], image: Path, library: Path, out: Path, width: int = 640) -> None:
    """Draw the scenes that `generate` wrote for one picture, ours or another's.

    Args:
        scenes: scene_<rank>.json files.
        image: the input picture, for the comparison.
        library: library.json.
        out: folder; gets a .png and a .glb for each scene, comparison.png, and in assets/ resized models it lacks.
        width: of the pictures, pixels.
    """
    folders = {entry.id: library.parent / entry.folder for entry in read_json(Library, library).assets}
    pictures = [("input", read_picture(image, width))]
    for path in progress(scenes, "scenes drawn", len(scenes)):
        made = read_json(GeneratedScene, path)
        items, sized = placed_items(made, folders, out / "assets", path)
        scene = make_scene(light=LIGHT)
        add_backdrop(scene, [item.box for item in items], made.walls, np.array(made.floor_from_camera)[:3, 3])
        load_items(scene, items, sized)
        picture = preview(scene, made, width)
        with atomic(out / f"{path.stem}.png") as temporary:
            Image.fromarray(picture).save(temporary)
        write_glb(items, sized, out / f"{path.stem}.glb")
        pictures.append((f"rank {made.rank}", picture))
    with atomic(out / "comparison.png") as temporary:
        side_by_side(pictures).save(temporary)


def placed_items(
    made: GeneratedScene, folders: dict[str, Path], cache: Path, path: Path
) -> tuple[list[Placed], dict[str, Path]]:
    """What stands in a scene, and by id the folders of the models at their sizes.

    Raises:
        InputError: nothing stands in it, or an asset is not in the library.
    """
    items, sized = [], {}
    for item in made.objects:
        if item.status != "ok":
            continue
        if item.asset not in folders:
            raise InputError(path, f"{item.id} is '{item.asset}', which the library does not have.")
        sized[item.id] = resized(folders[item.asset], item.size, cache)
        box = UprightBox(item.position, item.size, item.yaw)
        items.append(
            Placed(item.id, item.label, read_asset(sized[item.id]), box, item.mounting or STANDING, item.support)
        )
    if not items:
        raise InputError(path, "has no object that stands in it.")
    return items, sized
